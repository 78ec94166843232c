"""The channels of recordings at rest, each with what turns its samples into g or deg/h."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from procedures.anomalies.disturbances import CHANNEL_LABELS, EFFECT, Disturbance, rough_scale
from procedures.anomalies.disturbed_blocks import MIN_FINE, middle_half, rounding_of
from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.observations import channel
from procedures.frames import TRIADS
from procedures.inference import odds
from procedures.inference.marginal import log_mean
from procedures.inference.priors import PRESENT
from procedures.inference.result import CERTAIN, Finding


@dataclass(frozen=True, slots=True, eq=False)
class RestingChannel:
    """A channel's ``samples`` (n,) [output] at rest; ``per_unit`` outputs are 1 ``unit``, g or deg/h.

    ``label`` is ax ... gz; ``campaign`` and ``step`` number the recording.
    """

    campaign: int
    step: int
    rest: RestRecord
    triad: str
    axis: int
    samples: FloatArray
    per_unit: float

    @property
    def label(self) -> str:
        """The channel's name, ax ... gz."""
        return CHANNEL_LABELS[self.triad][self.axis]

    @property
    def unit(self) -> str:
        """The unit of its triad."""
        return "g" if self.triad == "accelerometer" else "deg/h"


def resting_channels(campaigns: Sequence[Campaign]) -> Iterator[RestingChannel]:
    """Yield the channels of every rest, rest by rest."""
    for number, campaign in enumerate(campaigns):
        for step, rest in enumerate(campaign.rests):
            for triad in TRIADS:
                if (samples := channel(rest.series, triad)) is None:
                    continue
                k = rough_scale(campaign, triad) * (rest.series.period if campaign.counts else 1.0)
                for axis in range(3):
                    x = np.asarray(samples[:, axis], dtype=np.float64)
                    yield RestingChannel(number, step, rest, triad, axis, x, float(abs(k[axis])))


BLOCK_S, MIN_BLOCK = 10.0, 48  # s, samples
MIN_BLOCKS, LEAST_SIDE = 20, 5
MIN_TIMES = 1.5  # by which the noise must be larger, or less: of a smaller change nothing depends
TINY = 1e-12
EDGES = 60  # of a change that does not last, tried for either end


def changed_noise(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each triad of a recording at rest whose noise changes for good."""
    for _, channels in groupby(resting_channels(campaigns), key=lambda one: (one.campaign, one.step, one.triad)):
        found = list[tuple[RestingChannel, _Change]]()
        for one in channels:
            length = max(round(BLOCK_S / one.rest.series.period), MIN_BLOCK)
            if (change := _change(one.samples, length)) is not None:
                found.append((one, change))
        if found:
            yield _changed_finding(*max(found, key=lambda each: each[1].sigmas), [one.label for one, _ in found])


def _changed_finding(one: RestingChannel, found: "_Change", names: Sequence[str]) -> Finding:
    where: dict[str, object] = {
        "file": one.rest.name, "channel": list(names) if len(names) > 1 else names[0],
        "from_s": float(one.rest.series.t[found.first]),
    }  # fmt: skip
    value = np.array([found.after - found.before]) / one.per_unit
    return Finding(
        EFFECT, "procedure", ("value",), value, np.abs(value) / found.sigmas, one.unit, where,
        found.probability, "the recording again, elsewhere and at another temperature",
        f"noise of a sample, {found.after / found.before:.2g} times what it was", fault="noise",
    ).or_else(f"{one.triad}.noise")  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Change:
    """A change for good at the sample ``first``: a sample's noise before and after, and how sure it is."""

    first: int
    before: float
    after: float
    sigmas: float
    probability: float


def _change(x: FloatArray, length: int) -> _Change | None:
    """Return where the noise of x (n,) changes for good, if that is likely; ``length`` samples are a block.

    The blocks' variances are known by how they scatter themselves. A change for good competes with one that goes
    back again, of which every begin and end is as likely.
    """
    count = len(x) // length
    if count < MIN_BLOCKS:
        return None
    variance = middle_half(x[: count * length].reshape(count, length))
    if not np.all(variance > 0) or float(np.median(variance)) < MIN_FINE * rounding_of([x]):
        return None
    v = np.log(variance)
    k = np.arange(LEAST_SIDE, count - LEAST_SIDE + 1)
    step, sigmas = _mean_inside(v, k, np.full(len(k), count))
    edges = np.unique(np.linspace(LEAST_SIDE, count - 1, EDGES).astype(int))
    i, j = (edges[which] for which in np.triu_indices(len(edges), 1))
    _, passing = _mean_inside(v, i, j)
    gains = [log_mean(odds.gain_of_squares(each**2, 1, count - 2)) for each in (sigmas, passing)]
    probability = odds.shares({"lasts": odds.log_odds(float(gains[0])), "passes": odds.log_odds(float(gains[1]))})
    best = int(np.argmax(sigmas))
    if probability["lasts"] < PRESENT or abs(step[best]) < 2 * np.log(MIN_TIMES):
        return None
    before = float(np.exp(np.mean(v[: k[best]]) / 2))
    after = before * float(np.exp(step[best] / 2))
    return _Change(int(k[best]) * length, before, after, float(sigmas[best]), probability["lasts"])


def _mean_inside(v: FloatArray, first: IntArray, end: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much v (n,) differs from ``first`` to ``end`` (m,) from all other values, and in sigmas."""
    sums = np.concatenate(([0.0], np.cumsum(v)))
    inside, number = sums[end] - sums[first], end - first
    of_others = len(v) - number
    means = inside / number, (sums[-1] - inside) / of_others
    left = np.maximum(np.sum(v**2) - number * means[0] ** 2 - of_others * means[1] ** 2, 0.0) / (len(v) - 2)
    step: FloatArray = means[0] - means[1]
    return step, np.abs(step) / np.sqrt(np.maximum(left, TINY) * (1 / number + 1 / of_others))


MIN_ROWS, MIN_SHARE = 20, 0.005  # that stand at one end
MIN_CLIPPED_TIMES = 20.0  # as often as any other value: a coarse output's values all come often


def clipped_channels(campaigns: Sequence[Campaign]) -> Iterator[Finding]:
    """Yield a finding for each channel of a recording at rest that stands at an end of its range for some rows."""
    for one in resting_channels(campaigns):
        levels, often = np.unique(one.samples, return_counts=True)
        if len(levels) < MIN_CLIPPED_TIMES:
            continue
        usual = int(np.max(often[1:-1]))
        for end, name in ((-1, "largest"), (0, "smallest")):
            rows = int(often[end])
            if rows >= max(MIN_ROWS, MIN_SHARE * len(one.samples)) and rows >= MIN_CLIPPED_TIMES * usual:
                yield _clipped_finding(one, float(levels[end]), rows, name)


def _clipped_finding(one: RestingChannel, value: float, rows: int, name: str) -> Finding:
    share = 100 * rows / len(one.samples)
    return Finding(
        EFFECT, "procedure", ("value",), np.array([value]) / one.per_unit,
        np.array([float(one.samples.std())]) / one.per_unit, one.unit,
        {"file": one.rest.name, "channel": one.label}, CERTAIN,
        "the recording again with a wider range",
        f"{share:.2g} % of the rows stand at its {name} value", fault="clipped",
    )  # fmt: skip


MAX_REPEATS = 0.2  # of the samples of a channel, outside the longest run, that may repeat the one before
MIN_RUN = 20  # samples of one value: a fifth to this power is once in 1e14
MAX_SHARE = 0.6  # of a recording that stands still; more of it is a channel that is dead


def frozen_stretches(campaigns: Sequence[Campaign]) -> Iterator[Disturbance]:
    """Yield the longest stretch at one value of each channel at rest, to be cut, with its finding.

    To the end of a recording it is a dead channel, which is left out (`dead_channels`): reported, and not cut.
    """
    taken = dict[tuple[int, int], list[tuple[int, int]]]()  # of each recording: channels freeze together
    for one in resting_channels(campaigns):
        first, end = _longest_run(one.samples)
        runs = taken.setdefault((one.campaign, one.step), [])
        if end - first < MIN_RUN or any(first < other and begin < end for begin, other in runs):
            continue
        runs.append((first, end))
        cut = end if end < len(one.samples) else first
        yield Disturbance(one.campaign, one.step, first, cut, np.inf, _frozen_finding(one, first, end))


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


def _frozen_finding(one: RestingChannel, first: int, end: int) -> Finding:
    t, x = one.rest.series.t, one.samples
    others = np.concatenate([x[:first], x[end:]])
    where = {"file": one.rest.name, "channel": one.label, "from_s": float(t[first]), "to_s": float(t[end - 1])}
    return Finding(
        EFFECT, "procedure", ("value",), np.array([x[first]]) / one.per_unit,
        np.array([float(others.std())]) / one.per_unit, one.unit, where, CERTAIN, "the recording again",
        fault="frozen",
    )  # fmt: skip
