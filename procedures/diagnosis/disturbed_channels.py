"""What each channel does in a disturbed stretch, against what it does beside it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.observations import channel
from procedures.counts.sample_records import Series
from procedures.diagnosis.disturbances import CHANNEL_LABELS, Disturbance
from procedures.diagnosis.rate_points import STD_PER_MAD
from procedures.frames import TRIADS

BESIDE_S = 10.0  # either side of a stretch, against which it is held
MIN_BESIDE = 100  # samples
APART = 10  # the part of a stretch that is left between it and what it is held against
MIN_LIVELINESS = 1.5  # rms over that beside it, from which on a channel shows a disturbance
STEP_SIGMAS = 5.0  # by which the levels before and after must differ for a step
MIN_STEP = 0.3  # of the rms in between, that they must differ by as well
LOUD = 8.0  # sigma of a sample that is far off by itself
MAX_ROWS = 5  # far off, of a stretch that is wrong rows and no knock
ONE_NUMBER = 1e-3  # of how far it is off, within which it is one: less the line that goes on beneath it
TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """A channel's samples (n,) in a stretch less their surroundings, over ``sigma`` of these [output].

    ``step`` is by how much the level after it is off that before it [sigma of a sample], ``step_sigmas`` the same
    over its own sigma; 0 at the end of a recording.
    """

    channel: str
    samples: FloatArray
    sigma: float
    step: float
    step_sigmas: float

    @property
    def is_lively(self) -> bool:
        """Say whether the stretch is livelier than what surrounds it."""
        return _rms(self.samples) > MIN_LIVELINESS

    @property
    def is_step(self) -> bool:
        """Say whether it does not come back: a jump, which is no knock."""
        excess = np.sqrt(max(_rms(self.samples) ** 2 - 1, 0.0))
        return bool(self.step_sigmas > STEP_SIGMAS and self.step > MIN_STEP * excess)


def wrong_rows(found: Sequence[Deviation]) -> IntArray:
    """Return the rows (m,) of a stretch, from its first, that are far off where nothing else is lively.

    None where there are more than `MAX_ROWS`, which are not one number: then it is a knock.
    """
    samples = np.stack([each.samples for each in found], axis=1)
    is_far = np.max(np.abs(samples), axis=1) > LOUD
    is_quiet = all(_rms(each.samples[~is_far]) < MIN_LIVELINESS for each in found)
    loudest = samples[is_far][:, np.argmax(np.max(np.abs(samples), axis=0))]
    is_few = len(loudest) <= MAX_ROWS or float(np.ptp(loudest)) < ONE_NUMBER * float(np.max(np.abs(loudest)))
    return np.flatnonzero(is_far if is_quiet and is_few else np.zeros_like(is_far))


def _rms(samples: FloatArray) -> float:
    return float(np.sqrt(np.mean(samples**2))) if len(samples) else 0.0


def deviations_in(series: Series, found: Disturbance) -> list[Deviation]:
    """Return what every channel of a recording does in a disturbed stretch."""
    length = max(round(BESIDE_S / series.period), MIN_BESIDE)
    apart = (found.end - found.first) // APART  # the disturbance may go on a little beyond what was found of it
    before = slice(max(found.first - apart - length, 0), max(found.first - apart, 0))
    after = slice(found.end + apart, found.end + apart + length)
    told = list[Deviation]()
    for triad in TRIADS:
        if (samples := channel(series, triad)) is None:
            continue
        for axis, name in enumerate(CHANNEL_LABELS[triad]):
            x = np.asarray(samples[:, axis], dtype=np.float64)
            told.append(_deviation(name, x[before], x[found.first : found.end], x[after], apart))
    return told


def _deviation(name: str, before: FloatArray, inside: FloatArray, after: FloatArray, apart: int) -> Deviation:
    """Hold a stretch's samples against a line of one slope and two levels through those ``apart`` beside it."""
    t = np.arange(len(inside), dtype=np.float64)
    t_beside = np.concatenate([np.arange(-len(before), 0) - apart, len(inside) + apart + np.arange(len(after))])
    A = np.stack([t_beside < 0, t_beside >= 0, t_beside], axis=1).astype(np.float64)
    values = np.concatenate([before, after])
    R = np.linalg.pinv(A)
    first, last, slope = R @ values
    off = values - A @ [first, last, slope]
    sigma = STD_PER_MAD * float(np.median(np.abs(off))) or float(off.std()) or TINY  # a coarse, a dead channel
    if len(before) == 0 or len(after) == 0:
        line = (last if len(after) else first) + slope * t
        return Deviation(name, (inside - line) / sigma, sigma, 0.0, 0.0)
    line, step = (first + last) / 2 + slope * t, abs(float(last - first)) / sigma
    return Deviation(name, (inside - line) / sigma, sigma, step, step / float(np.linalg.norm(R[1] - R[0])))
