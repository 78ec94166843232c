"""Vibration rectification: a sensor's mean follows the variance of the vibration.

An accelerometer's own along its axis, ``K (a - mean)^2``; a gyroscope's that of all accelerometers together, since
a coil or a proof mass may be shaken along any axis.

Means and variances of short stretches, 1 s at most, are compared. A skewed noise has both from the same
samples; so the mean is taken of every other sample and the variance of those between, and the other way round. The
variance is that of differences: what is slow is no vibration.

Source: IEEE Std 1293, vibration rectification coefficient [g/g^2]; IEEE Std 952, sensitivity to vibration.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES
from procedures.inference import odds
from procedures.inference.result import Finding, FoldedResidual
from procedures.samples.sample_blocks import LEFT_OUT, SampleBlocks, Scores, detrended, fit_scores
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G

EFFECT = "{}.vibration_rectification"
STRETCH_S, MIN_STRETCH = 1.0, 32  # samples at the least
GROUPS, MIN_GROUP, MAX_GROUP = 24, 16, 64  # of stretches that are compared; stretches in one
BINS = 20  # by variance, of a plot
MOST = {"accelerometer": 1.0, "gyroscope": 5e4}  # g/g^2, deg/h/g^2: more no sensor rectifies
Shaken = tuple[int, Sequence[int]]
"""A sensor, and those that say how it is shaken."""
SEPARATE = "a shaker, or the noisy neighbour switched on and off while the unit rests"


def rectified(blocks: SampleBlocks, is_usable: Sequence[bool], names: list[str]) -> Iterator[Finding]:
    """Yield a finding of each triad with sensors whose means follow the variance."""
    shaken = _of_triad(blocks, is_usable, "accelerometer")
    pairs = {
        "accelerometer": [(sensor, [sensor]) for sensor in shaken],
        "gyroscope": [(sensor, shaken) for sensor in _of_triad(blocks, is_usable, "gyroscope") if shaken],
    }
    for triad in pairs:
        yield from _rectified(blocks, triad, pairs[triad], names)


def _of_triad(blocks: SampleBlocks, is_usable: Sequence[bool], triad: str) -> list[int]:
    return [i for i, each in enumerate(blocks.sensors) if each.triad == triad and is_usable[i]]


def _rectified(blocks: SampleBlocks, triad: str, sensors: Sequence[Shaken], names: list[str]) -> Iterator[Finding]:
    stretch = max(round(STRETCH_S / blocks.period), MIN_STRETCH)
    factor, unit = (DEG_H_PER_DEG_S, "deg/h/g^2") if triad == "gyroscope" else (1.0, "g/g^2")
    fits = {}
    for sensor, shaken in sensors:
        scores = _scores(blocks, sensor, shaken, stretch)
        fit = fit_scores(scores, 0, 1) if len(scores.gram) >= LEFT_OUT else None
        if fit is not None and odds.log_odds(fit.gain, len(sensors)) > 0 and fit.share > 0:
            fits[sensor] = fit
    if not fits:
        return
    value = np.concatenate([fit.value for fit in fits.values()])
    probability = odds.probability(odds.log_odds(max(fit.gain for fit in fits.values()), len(sensors)))
    is_too_large = float(np.max(np.abs(factor * value))) > MOST[triad]  # knocks shake and move at once
    found = Finding(
        EFFECT.format(triad), "instrument", tuple(AXES[blocks.sensors[s].axis] for s in fits), factor * value,
        factor * np.array([np.sqrt(fit.covariance[0, 0]) for fit in fits.values()]), unit,
        {"file": names}, probability, SEPARATE, share=max(fit.share for fit in fits.values()),
    )  # fmt: skip
    yield found.or_else("disturbance.dwell") if is_too_large else found


def by_variance(blocks: SampleBlocks, is_usable: Sequence[bool], finding: Finding) -> Iterator[FoldedResidual]:
    """Yield the means of stretches by their variances, without the finding and with it, of each of its sensors.

    Stretches are put together by the variance of one half of their samples, and what it was is determined by the
    other's: the highest of many noisy variances is too high.
    """
    stretch = max(round(STRETCH_S / blocks.period), MIN_STRETCH)
    triad = finding.effect.partition(".")[0]
    is_gyro, all_shaken = triad == "gyroscope", _of_triad(blocks, is_usable, "accelerometer")
    factor, unit = (DEG_H_PER_DEG_S, "deg/h") if is_gyro else (UG_PER_G, "ug")
    numbers = {AXES[blocks.sensors[i].axis]: i for i in _of_triad(blocks, is_usable, triad)}
    for name, value in zip(finding.coefficients, finding.value.tolist(), strict=True):
        K = value / DEG_H_PER_DEG_S if is_gyro else value
        shaken = all_shaken if is_gyro else [numbers[name]]
        groups = [(detrended(m), detrended(v)) for m, v in _groups(blocks, numbers[name], shaken, stretch)]
        mean, variance = (np.concatenate([each[i] for each in groups]) for i in (0, 1))
        left, other = (mean - K * variance[:, ::-1]).ravel(), variance[:, ::-1].ravel()
        at = np.searchsorted(np.quantile(variance, np.linspace(0, 1, BINS + 1)[1:-1]), variance.ravel())
        count = np.maximum(np.bincount(at, minlength=BINS), 1)
        where, before, after = (np.bincount(at, v, BINS) / count for v in (other, mean.ravel(), left))
        yield FoldedResidual(
            finding.effect, "", triad, AXES.index(name), unit, 1e6 * where, factor * before, factor * after,
            factor * np.std(left) / np.sqrt(count), "variance of the vibration less its slow part [mg^2]",
        )  # fmt: skip


def _scores(blocks: SampleBlocks, sensor: int, shaken: Sequence[int], stretch: int) -> Scores:
    """Return what every group of stretches says of the coefficient of what shakes the sensors ``shaken``.

    How much the variance truly moved is the product of both of its halves: their squares hold their own scatter.
    """
    gram, score, squares = list[float](), list[float](), list[float]()
    for mean, variance in _groups(blocks, sensor, shaken, stretch):
        e, v = detrended(mean), detrended(variance)
        gram.append(2 * float(np.sum(v[:, 0] * v[:, 1])))
        score.append(float(np.sum(v * e)))
        squares.append(float(np.sum(e * e)))
    n = len(gram)
    return Scores(np.array(gram).reshape(n, 1, 1), np.array(score).reshape(n, 1, 1), np.array(squares)[:, None])


def _groups(
    blocks: SampleBlocks, sensor: int, shaken: Sequence[int], stretch: int
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield means and variances (m, 2) of the stretches that follow one another."""
    stretches = sum(len(channels[sensor].rate) for channels in blocks.channels) // stretch
    size = int(np.clip(stretches // GROUPS, MIN_GROUP, MAX_GROUP))
    for channels in blocks.channels:
        for part in channels[sensor].parts:
            mean, _ = _stretches(channels[sensor].rate[part], stretch)
            variance = np.sum([_stretches(channels[s].rate[part], stretch)[1] for s in shaken], axis=0)
            groups = max(len(mean) // size, 1)
            if len(mean) >= MIN_GROUP:
                yield from zip(np.array_split(mean, groups), np.array_split(variance, groups), strict=True)


def _stretches(rate: FloatArray, stretch: int) -> tuple[FloatArray, FloatArray]:
    """Return means and variances (m, 2) of stretches: of even samples next to those of odd ones, and crosswise."""
    pairs = rate[: len(rate) // stretch * stretch].reshape(-1, stretch)[:, : stretch // 2 * 2]
    even, odd = pairs[:, ::2], pairs[:, 1::2]
    mean = np.stack((even.mean(axis=1), odd.mean(axis=1)), axis=1)
    variance = np.stack([np.mean(np.diff(other, axis=1) ** 2, axis=1) / 2 for other in (odd, even)], axis=1)
    return mean, variance


TURNS = (1.0, 2 * np.pi, 360.0)  # one turn, in the units that an angle is stated in
MAX_HARMONIC = 12
STEADY_SHARE = 0.02  # of its step from sample to sample, by which a steady angle's steps may differ
WITHIN_CYCLES = 1.0  # of a whole recording, within which two frequencies are one


def steady_channels(blocks: SampleBlocks, hertz: float) -> tuple[str, ...]:
    """Return the auxiliary channels whose angle goes round evenly, a whole share of ``hertz`` times a second."""
    return tuple(
        name
        for name, values in blocks.auxiliary.items()
        if all(any(_makes(value, turn, hertz * blocks.period) for turn in TURNS) for value in values)
    )


def _makes(values: FloatArray, turn: float, line: float) -> bool:
    """Say whether an angle (n,), of so much a ``turn``, makes a line of ``line`` cycles a sample."""
    steps = np.diff(values) / turn
    step = float(np.median(steps))
    off = np.abs(steps - step)
    off = np.minimum(off, np.abs(off - np.round(off)))  # a whole turn is where it wraps
    if not step or np.quantile(off, 0.99) > STEADY_SHARE * abs(step):
        return False
    harmonic = round(line / abs(step))
    return 1 <= harmonic <= MAX_HARMONIC and abs(line - harmonic * abs(step)) * len(values) < WITHIN_CYCLES
