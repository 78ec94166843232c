"""What a unit's outputs scatter by: the variance of a dwell's rate, a turn's total and a move's rotation."""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import REMAINDER_COUNTS, WHITE_NOISE_FACTOR
from procedures.units import RAD_PER_ARCSEC, RAD_PER_DEG

REMAINDERS_OF_A_DWELL = 2.0  # `REMAINDER_COUNTS` is of a bias: half the root of the sum of four dwells' squares
CONING_RAD = 0.15 * RAD_PER_ARCSEC  # rad, 1 sigma of what coning leaves of a move of hands at 50 Hz


@dataclass(frozen=True, slots=True, eq=False)
class UnitNoise:
    """White noise (3,) of the accelerometers [g sqrt(s)] and gyroscopes [deg/sqrt(s)], and what one count is.

    ``accel_scale`` (3,) [count/(g s)] and ``gyro_scale`` (3,) [count/deg] are infinite where nothing is counted.
    ``wander`` [deg/s] is 1 sigma of the gyroscopes' bias from step to step.
    """

    accel_white: FloatArray
    gyro_white: FloatArray
    accel_scale: FloatArray
    gyro_scale: FloatArray
    wander: float

    def times(self, accel: float, gyro: float) -> "UnitNoise":
        """Return it with white noise that is larger by these factors."""
        return replace(self, accel_white=accel * self.accel_white, gyro_white=gyro * self.gyro_white)

    def accel_variance(self, seconds: FloatArray) -> FloatArray:
        """Return (n, 3) [g2] of the specific force in dwells of ``seconds`` (n,)."""
        return _dwell_variance(self.accel_white, self.accel_scale, seconds)

    def gyro_variance(self, seconds: FloatArray) -> FloatArray:
        """Return (n, 3) [deg2/s2] of the rate in dwells of ``seconds`` (n,), the bias's wander in it."""
        return _dwell_variance(self.gyro_white, self.gyro_scale, seconds) + self.wander**2

    def turn_variance(self, seconds: float) -> FloatArray:
        """Return (3,) [deg2] of the total of a turn of ``seconds``; a counter's two remainders have 1/6."""
        found: FloatArray = (
            self.gyro_white**2 * seconds + 1 / 6 / self.gyro_scale**2 + (self.wander * seconds) ** 2
        )
        return found

    def move_variance(self, seconds: float) -> float:
        """Return [rad2] of each component of a move's rotation: noise, rounding, the bias's wander, coning."""
        rounding = 2 / 12 * float(np.mean(1 / self.gyro_scale**2))
        white = float(np.mean(self.gyro_white**2)) * seconds
        return (white + rounding + (self.wander * seconds) ** 2) * RAD_PER_DEG**2 + CONING_RAD**2


def _dwell_variance(white: FloatArray, scale: FloatArray, seconds: FloatArray) -> FloatArray:
    T = np.asarray(seconds)[:, None]
    remainder = REMAINDERS_OF_A_DWELL * REMAINDER_COUNTS / (scale * T)
    found: FloatArray = (WHITE_NOISE_FACTOR * white) ** 2 / T + remainder**2
    return found
