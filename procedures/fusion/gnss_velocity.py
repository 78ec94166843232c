"""GNSS velocities between two keyframes, carried by the IMU to the later one and taken together."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.preintegration import Preintegrated
from procedures.fusion.records import GnssFixes, ImuSeries


@dataclass(frozen=True, slots=True, eq=False)
class LeverArm:
    """Where it is: ``lever`` (3,) [m] from the IMU in b, and 1 sigma of each axis."""

    lever: FloatArray
    std: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Velocities:
    """Fixes, and the rate of b at each (n, 3) [rad/s]."""

    fixes: GnssFixes
    rate_b: FloatArray

    def at_end(
        self, t0: float, part: Preintegrated, C_nb: FloatArray, pull: FloatArray, antenna: LeverArm
    ) -> tuple[FloatArray, FloatArray]:
        """Return the IMU's velocity (3,) at the end of ``part`` by all fixes since ``t0``, and its weight (3,).

        ``C_nb`` is the attitude at t0, ``pull`` (3,) [m/s2] gravity and Coriolis acceleration. What no fix says
        has weight 0.
        """
        which = slice(*np.searchsorted(self.fixes.t, [t0, t0 + part.dt], "right"))
        since = self.fixes.t[which] - t0
        if not len(since):
            return np.zeros(3), np.zeros(3)
        gained = np.stack([np.interp(since, part.edges, part.dv_from[:, i]) for i in range(3)], axis=1)
        share = (since / part.dt)[:, None, None]
        C_nf = C_nb @ ((1 - share) * np.eye(3) + share * part.turn)  # of a lever arm, good enough within 0.1 s
        arm = np.einsum("nij,nj->ni", C_nf, np.cross(self.rate_b[which], antenna.lever))
        v = self.fixes.v_n[which] - arm + (part.dv - gained) @ C_nb.T + pull * (part.dt - since)[:, None]
        unsure = antenna.std**2 * np.sum(self.rate_b[which] ** 2, axis=1)
        variance = np.nan_to_num(self.fixes.velocity_std[which], nan=np.inf) ** 2 + unsure
        weight = np.where(np.isfinite(v), 1 / variance[:, None], 0.0)
        total = weight.sum(axis=0)
        return (weight * np.nan_to_num(v)).sum(axis=0) / np.maximum(total, 1e-12), total


def velocities(fixes: GnssFixes, imu: ImuSeries, gyro_bias: FloatArray) -> Velocities:
    """Return fixes with the IMU's rate at each, its bias taken off."""
    rate = np.stack([np.interp(fixes.t, imu.t, imu.omega_b[:, i]) for i in range(3)], axis=1)
    return Velocities(fixes, rate - gyro_bias)
