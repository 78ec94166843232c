"""How a gyro says that a body turned between any two moments, and how that depends on its bias."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation, rotation_vector
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.imu.inertial_increments import products

RATE_HALF_SPAN_S = 0.03  # s about a moment, over which its rate is taken: a sample alone is vibration


class GyroRotations:
    """Samples integrated once with a constant bias [rad/s], then asked at any times.

    Rates are straight between samples; within an interval its mean rate is taken.
    """

    def __init__(self, imu: ImuSeries, bias: FloatArray) -> None:
        dt = np.diff(imu.t)[:, None]
        self.t, self._rate = imu.t, (imu.omega_b[1:] + imu.omega_b[:-1]) / 2 - bias
        self._C = products(rotation(self._rate * dt))
        middle = self._C[:-1] @ rotation(self._rate * dt / 2)
        self._Phi = np.concatenate((np.zeros((1, 3, 3)), np.cumsum(middle * dt[:, :, None], axis=0)))

    def turned(self, t0: FloatArray, t1: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return C_10 (n, 3, 3), from b at ``t0`` to b at ``t1`` (n,) [s], and its left turn by the bias."""
        (C0, Phi0), (C1, Phi1) = self._at(t0), self._at(t1)
        back = np.swapaxes(C1, 1, 2)
        return back @ C0, back @ (Phi1 - Phi0)

    def rate(self, t: FloatArray) -> FloatArray:
        """Return the mean rates (n, 3) [rad/s] in b about the times ``t`` (n,) [s]."""
        turned, _ = self.turned(t + RATE_HALF_SPAN_S, t - RATE_HALF_SPAN_S)
        return rotation_vector(turned) / (2 * RATE_HALF_SPAN_S)

    def _at(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        k = np.clip(np.searchsorted(self.t, t, "right") - 1, 0, len(self._rate) - 1)
        since = (t - self.t[k])[:, None]
        return self._C[k] @ rotation(self._rate[k] * since), self._Phi[k] + self._C[k] * since[:, :, None]
