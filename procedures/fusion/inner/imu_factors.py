"""An IMU between keyframes, preintegrated (Forster, Carlone, Dellaert, Scaramuzza 2017) by gtsam.

With the biases' random walks and the exact rotation of the Earth. Over a gap of the IMU a straight line is
integrated, with noise of a density that has made of it at its end what such a line misses.
"""

from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuNoise, ImuSeries
from procedures.fusion.imu.imu_gaps import ImuGap, imu_gaps
from procedures.fusion.imu.inertial_increments import ImuGrid, grid

INTEGRATION = 1e-8  # m2/s, error of integrating the position


class Preintegration:
    """The samples between keyframes at ``t`` (n,) [s]; ``rate`` (n, 3) [rad/s] is the IMU's at them, with bias."""

    def __init__(
        self, lib: Any, noise: ImuNoise, gravity: float, earth_n: FloatArray, imu: ImuSeries, t: FloatArray
    ) -> None:
        self.rate = np.stack([np.interp(t, imu.t, imu.omega_b[:, i]) for i in range(3)], axis=1)
        self._lib, self._noise, self._gravity, self._earth_n, self._t = lib, noise, gravity, earth_n, t
        self._grid = grid(imu, t)
        self._usual = self._params()
        self._gaps = [(gap, self._params(gap)) for gap in imu_gaps(imu)]

    def until(self, k: int, bias: Any) -> Any:
        """Return what gtsam makes of the samples from keyframe k - 1 to k."""
        middle = (self._t[k - 1] + self._t[k]) / 2
        params = next((each for gap, each in self._gaps if gap.first < middle < gap.last), self._usual)
        whole = self._lib.PreintegratedCombinedMeasurements(params, bias)
        for i in range(int(self._grid.at[k - 1]), int(self._grid.at[k])):
            whole.integrateMeasurement(self._grid.f_b[i], self._grid.omega_b[i], self._grid.dt[i])
        return whole

    def go_on(self, k: int, piece: ImuGrid, t: FloatArray, rate: FloatArray, gaps: tuple[ImuGap, ...]) -> None:
        """Lay keyframe ``k``, the last of ``t`` (k + 1,) [s]; samples of those before are forgotten.

        ``piece`` has its samples, ``gaps`` are those of all that are at hand.
        """
        at = np.zeros(k + 1, dtype=np.int64)
        at[k] = len(piece.dt)
        self._grid = ImuGrid(piece.dt, piece.omega_b, piece.f_b, at)
        self.rate, self._t = np.broadcast_to(rate, (k + 1, 3)), t
        self._gaps = [(gap, self._params(gap)) for gap in gaps]

    def acceleration(self, k: int, C_nb: FloatArray, accel_bias: FloatArray) -> FloatArray:
        """Return the acceleration (3,) in n [m/s2] over the step to keyframe k, or of the first."""
        part = slice(int(self._grid.at[max(k - 1, 0)]), int(self._grid.at[max(k, 1)]))
        f_b = np.average(self._grid.f_b[part], axis=0, weights=self._grid.dt[part]) - accel_bias
        a_n: FloatArray = C_nb @ f_b - np.array([0.0, 0.0, self._gravity])
        return a_n

    def _params(self, gap: ImuGap | None = None) -> Any:
        noise, eye = self._noise, np.eye(3)
        gyro, accel = noise.gyro**2, noise.accel**2
        if gap is not None:
            gyro, accel = gyro + gap.rate_std**2 * gap.length, accel + gap.force_std**2 * gap.length
        params = self._lib.PreintegrationCombinedParams(np.array([0.0, 0.0, -self._gravity]))
        params.setGyroscopeCovariance(gyro * eye)
        params.setAccelerometerCovariance(accel * eye)
        params.setBiasOmegaCovariance(noise.gyro_walk**2 * eye)
        params.setBiasAccCovariance(noise.accel_walk**2 * eye)
        params.setIntegrationCovariance(INTEGRATION * eye)
        params.setOmegaCoriolis(self._earth_n)
        return params
