"""What each channel does in a disturbed stretch, against what it does beside it."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.observations import channel
from procedures.counts.sample_records import Series
from procedures.diagnosis.disturbances import CHANNEL_LABELS, Disturbance
from procedures.diagnosis.rate_points import STD_PER_MAD
from procedures.frames import TRIADS

BESIDE_S = 10.0  # either side of a stretch, against which it is held
MIN_LIVELINESS = 1.5  # rms over that beside it, from which on a channel shows a disturbance
STEP_SIGMAS, MIN_STEP = (
    5.0,
    0.3,
)  # of the means before and after; of the rms in between, from which on it is a step
LOUD = 8.0  # sigma of a sample that is far off by itself
MAX_ROWS = 2  # far off, of a stretch that is wrong rows and no knock
TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """A channel's samples (n,) in a stretch less their surroundings, over ``sigma`` of these [output].

    ``step`` is by how much the mean after it is more than that before it, [sigma of a sample].
    """

    channel: str
    samples: FloatArray
    sigma: float
    step: float
    beside: int

    @property
    def is_lively(self) -> bool:
        """Say whether the stretch is livelier than what surrounds it."""
        return _rms(self.samples) > MIN_LIVELINESS or self.is_of_rows

    @property
    def is_of_rows(self) -> bool:
        """Say whether a row or two are far off, and nothing else is."""
        is_far = np.abs(self.samples) > LOUD
        return 0 < int(is_far.sum()) <= MAX_ROWS and _rms(self.samples[~is_far]) < MIN_LIVELINESS

    @property
    def is_step(self) -> bool:
        """Say whether it does not come back: a jump, which is no knock."""
        excess = np.sqrt(max(_rms(self.samples) ** 2 - 1, 0.0))
        return bool(self.step * np.sqrt(self.beside / 2) > STEP_SIGMAS and self.step > MIN_STEP * excess)


def _rms(samples: FloatArray) -> float:
    return float(np.sqrt(np.mean(samples**2))) if len(samples) else 0.0


def deviations_in(series: Series, found: Disturbance) -> list[Deviation]:
    """Return what every channel of a recording does in a disturbed stretch."""
    length = round(BESIDE_S / series.period)
    before = slice(max(found.first - length, 0), found.first)
    after = slice(found.end, found.end + length)
    told = list[Deviation]()
    for triad in TRIADS:
        if (samples := channel(series, triad)) is None:
            continue
        for axis, name in enumerate(CHANNEL_LABELS[triad]):
            x = np.asarray(samples[:, axis], dtype=np.float64)
            sides = [x[side] for side in (before, after) if len(x[side])]
            level = float(np.median(np.concatenate(sides)))
            about = np.concatenate([np.abs(side - np.median(side)) for side in sides])
            sigma = STD_PER_MAD * float(np.median(about)) or float(about.std()) or TINY  # a coarse, a dead channel
            step = abs(float(sides[-1].mean() - sides[0].mean())) / sigma if len(sides) > 1 else 0.0
            beside = min(len(side) for side in sides)
            told.append(Deviation(name, (x[found.first : found.end] - level) / sigma, sigma, step, beside))
    return told
