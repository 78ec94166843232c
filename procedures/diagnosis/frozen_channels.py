"""Channels that stand still for a while, where they change otherwise: a frozen register, a stuck log."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.disturbances import EFFECT, Disturbance
from procedures.diagnosis.resting_channels import RestingChannel, resting_channels
from procedures.diagnosis.result import CERTAIN, Finding

MAX_REPEATS = 0.2  # of the samples of a channel, outside the longest run, that may repeat the one before
MIN_RUN = 20  # samples of one value: a fifth to this power is once in 1e14
MAX_SHARE = 0.6  # of a recording that stands still; more of it is a channel that is dead


def frozen_stretches(campaigns: Sequence[Campaign]) -> Iterator[Disturbance]:
    """Yield the longest stretch at one value of each channel at rest, to be cut, with its finding.

    To the end of a recording it is a dead channel, which is left out (`dead_channels`): said, and not cut.
    """
    taken = dict[tuple[int, int], list[tuple[int, int]]]()  # of each recording: channels freeze together
    for one in resting_channels(campaigns):
        first, end = _longest_run(one.samples)
        told = taken.setdefault((one.campaign, one.step), [])
        if end - first < MIN_RUN or any(first < other and begin < end for begin, other in told):
            continue
        told.append((first, end))
        cut = end if end < len(one.samples) else first
        yield Disturbance(one.campaign, one.step, first, cut, _finding(one, first, end))


def _longest_run(x: FloatArray) -> tuple[int, int]:
    """Return the first sample and the end of the longest run of one value in x (n,); empty of a coarse channel."""
    edges = np.concatenate(([0], np.flatnonzero(np.diff(x) != 0) + 1, [len(x)]))
    lengths = np.diff(edges)
    longest = int(np.argmax(lengths))
    others = len(x) - int(lengths[longest])
    repeats = others - (len(lengths) - 1)
    if others < (1 - MAX_SHARE) * len(x) or repeats > MAX_REPEATS * others:
        return 0, 0
    return int(edges[longest]), int(edges[longest + 1])


def _finding(one: RestingChannel, first: int, end: int) -> Finding:
    t, x = one.rest.series.t, one.samples
    others = np.concatenate([x[:first], x[end:]])
    where = {"file": one.rest.name, "channel": one.label, "from_s": float(t[first]), "to_s": float(t[end - 1])}
    return Finding(
        EFFECT, "procedure", ("value",), np.array([x[first]]) / one.per_unit,
        np.array([float(others.std())]) / one.per_unit, one.unit, where, CERTAIN, "the recording again",
        None, "frozen at one value",
    )  # fmt: skip
