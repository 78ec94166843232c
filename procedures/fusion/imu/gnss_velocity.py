"""GNSS velocities between two keyframes, carried by the IMU to the later one and taken together.

A receiver that does not tell its vertical velocity holds it by its heights, weakly: else an IMU alone would come
to climb by what its accelerometers are off.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.preintegration import Preintegrated

CLIMB_SPAN_S = 5.0  # s over which heights tell how fast they rise
CLIMB_RATE_STD = 0.3  # m/s by which that is not how fast they rise now


@dataclass(frozen=True, slots=True, eq=False)
class LeverArm:
    """Where it is: ``lever`` (3,) [m] from the IMU in b, and 1 sigma of each axis."""

    lever: FloatArray
    std: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class GnssVelocities:
    """At ``t`` (n,) [s]: ``v_n`` and its ``std`` (n, 3) [m/s], inf where none is, ``rate_b`` (n, 3) [rad/s]."""

    t: FloatArray
    v_n: FloatArray
    std: FloatArray
    rate_b: FloatArray

    def at_end(
        self, t0: float, part: Preintegrated, C_nb: FloatArray, pull: FloatArray, antenna: LeverArm
    ) -> tuple[FloatArray, FloatArray]:
        """Return the IMU's velocity (3,) at the end of ``part`` by all fixes since ``t0``, and its weight (3,).

        ``C_nb`` is the attitude at t0, ``pull`` (3,) [m/s2] gravity and Coriolis acceleration. What no fix says
        has weight 0.
        """
        which = slice(*np.searchsorted(self.t, [t0, t0 + part.dt], "right"))
        since = self.t[which] - t0
        if not len(since):
            return np.zeros(3), np.zeros(3)
        gained = interpolated(since, part.edges, part.dv_from)
        share = (since / part.dt)[:, None, None]
        C_nf = C_nb @ ((1 - share) * np.eye(3) + share * part.turn)  # of a lever arm, good enough within 0.1 s
        arm = np.einsum("nij,nj->ni", C_nf, np.cross(self.rate_b[which], antenna.lever))
        v = self.v_n[which] - arm + (part.dv - gained) @ C_nb.T + pull * (part.dt - since)[:, None]
        unsure = antenna.std**2 * np.sum(self.rate_b[which] ** 2, axis=1)
        weight = 1 / (self.std[which] ** 2 + unsure[:, None])
        total = weight.sum(axis=0)
        return (weight * v).sum(axis=0) / np.maximum(total, 1e-12), total


def velocities(fixes: GnssFixes, imu: ImuSeries, gyro_bias: FloatArray) -> GnssVelocities:
    """Return what fixes say of velocity, and the IMU's rate at each, ``gyro_bias`` (3,) [rad/s] taken off."""
    rate = interpolated(fixes.t, imu.t, imu.omega_b)
    told = np.isfinite(fixes.v_n) & np.isfinite(fixes.velocity_std)[:, None]
    v, std = np.where(told, fixes.v_n, 0.0), np.where(told, fixes.velocity_std[:, None], np.inf)
    climb, climb_std = _climb(fixes)
    untold = ~told[:, 2] & np.isfinite(climb)
    v[untold, 2], std[untold, 2] = climb[untold], climb_std[untold]
    return GnssVelocities(fixes.t, v, std, rate - gyro_bias)


def _climb(fixes: GnssFixes) -> tuple[FloatArray, FloatArray]:
    """Return how fast the height rose before each fix (n,) [m/s], nan where that is not known, and 1 sigma.

    Fixes that share their spans are no better than one of each span.
    """
    t, up = fixes.t, fixes.p_n[:, 2]
    first = np.searchsorted(t, t - CLIMB_SPAN_S)
    span, count = t - t[first], np.arange(len(t)) - first
    known = span > CLIMB_SPAN_S / 2
    over = np.where(known, span, 1.0)
    std = np.hypot(fixes.position_std, fixes.position_std[first]) / over
    return np.where(known, (up - up[first]) / over, np.nan), np.sqrt(count) * np.hypot(std, CLIMB_RATE_STD)
