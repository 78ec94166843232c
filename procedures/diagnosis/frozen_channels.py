"""Channels that stand still for a while, where they change otherwise: a frozen register, a stuck log."""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.diagnosis.disturbances import CHANNEL_LABELS, EFFECT, Disturbance, rough_scale
from procedures.diagnosis.result import Finding
from procedures.frames import TRIADS

MAX_REPEATS = 0.2  # of the samples of a channel, outside the longest run, that may repeat the one before
MIN_RUN = 20  # samples of one value: a fifth to this power is once in 1e14
MAX_SHARE = 0.6  # of a recording that stands still; more of it is a channel that is dead


def frozen_stretches(campaigns: Sequence[Campaign]) -> Iterator[Disturbance]:
    """Yield the longest stretch at one value of each channel at rest, to be cut, with its finding."""
    for number, campaign in enumerate(campaigns):
        for step, rest in enumerate(campaign.rests):
            runs = [(*_longest_run(x), triad, axis, x) for triad, axis, x in _channels(rest)]
            frozen = [each for each in runs if each[1] - each[0] >= MIN_RUN]
            taken = np.zeros(len(rest.series), dtype=bool)
            for first, end, triad, axis, x in frozen:
                if not taken[first:end].any():
                    # to the end it is a dead channel, which is left out (`dead_channels`): said, and not cut
                    cut = end if end < len(x) else first
                    taken[first:cut] = True
                    told = _finding(campaign, rest, triad, axis, x, first, end)
                    yield Disturbance(number, step, first, cut, told)


def _channels(rest: RestRecord) -> Iterator[tuple[str, int, FloatArray]]:
    for triad in TRIADS:
        if (samples := channel(rest.series, triad)) is not None:
            for axis in range(3):
                yield triad, axis, np.asarray(samples[:, axis], dtype=np.float64)


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


def _finding(
    campaign: Campaign, rest: RestRecord, triad: str, axis: int, x: FloatArray, first: int, end: int
) -> Finding:
    k = float(rough_scale(campaign, triad)[axis]) * (rest.series.period if campaign.counts else 1.0)
    unit = "g" if triad == "accelerometer" else "deg/h"
    t = rest.series.t
    where: dict[str, object] = {
        "file": rest.name, "channel": CHANNEL_LABELS[triad][axis],
        "from_s": float(t[first]), "to_s": float(t[end - 1]),
    }  # fmt: skip
    others = np.concatenate([x[:first], x[end:]])
    return Finding(
        EFFECT, "procedure", ("value",), np.array([x[first] / k]), np.array([float(others.std()) / abs(k)]), unit,
        where, "established", (), "the recording again", float((first - end) * np.log(1 / MAX_REPEATS)), 0.0,
        "frozen at one value",
    )  # fmt: skip
