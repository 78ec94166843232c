"""Where an IMU lost samples, and what a straight line over the loss costs.

A gap is bridged by the line between its ends. How far such a line is off is asked of the recording itself: the
difference between the mean of the samples over as long a time and the mean of that time's ends, rms over it all.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries

MIN_GAP_PERIODS = 5.0  # of the samples, from which a step is a gap: what is shorter a line follows


@dataclass(frozen=True, slots=True)
class ImuGap:
    """From ``first`` to ``last`` [s]; 1 sigma of the mean rate [rad/s] and specific force [m/s2] of the line."""

    first: float
    last: float
    rate_std: float
    force_std: float

    @property
    def length(self) -> float:
        """How long it is [s]."""
        return self.last - self.first


def imu_gaps(imu: ImuSeries) -> tuple[ImuGap, ...]:
    """Return the gaps of a recording."""
    dt = np.diff(imu.t)
    period = float(np.median(dt))
    return tuple(
        ImuGap(float(imu.t[i]), float(imu.t[i + 1]), _missed(imu.omega_b, n), _missed(imu.f_b, n))
        for i in np.flatnonzero(dt > MIN_GAP_PERIODS * period)
        if (n := min(round(dt[i] / period), len(dt)))
    )


def _missed(values: FloatArray, n: int) -> float:
    """Return the rms, of an axis, of the mean of n + 1 samples less that of the first and the last of them."""
    total = np.concatenate((np.zeros((1, 3)), np.cumsum(values, axis=0)))
    mean = (total[n + 1 :] - total[: -n - 1]) / (n + 1)
    ends = (values[n:] + values[: len(values) - n]) / 2
    return float(np.sqrt(np.mean((mean - ends) ** 2)))
