"""What GNSS says between two keyframes: velocities, carried by the IMU to the later one, and positions.

A receiver without vertical velocity holds it by its heights, weakly.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, interpolated
from procedures.frames import skew
from procedures.fusion.fusion_records import GnssFixes, ImuSeries, KeyframeWheel
from procedures.fusion.preintegration import Preintegrated

CLIMB_SPAN_S = 5.0  # s over which the rate of heights is taken
CLIMB_RATE_STD = 0.3  # m/s by which that is not how fast they rise now


@dataclass(frozen=True, slots=True, eq=False)
class LeverArm:
    """Where it is: ``lever`` (3,) [m] from the IMU in b, and 1 sigma of each axis."""

    lever: FloatArray
    std: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeFix:
    """What fixes say at a keyframe; weights are inverse variances, 0 where nothing is measured.

    ``v`` (3,) [m/s] of the antenna with ``v_weight`` (3,); ``p`` (3,) [m] of it, ``age`` [s] after the keyframe,
    with ``p_weight`` (3,). The antenna stands at ``lever`` (3,) [m] in b, and moves there by ``swing`` (3, 3)
    [rad/s] times that; ``a`` (3,) [m/s2] is the IMU's acceleration in n. ``wheel`` is what a wheel says there.
    """

    v: FloatArray
    v_weight: FloatArray
    p: FloatArray
    p_weight: FloatArray
    age: float
    lever: FloatArray
    swing: FloatArray
    a: FloatArray
    wheel: KeyframeWheel | None = None


def no_fix() -> KeyframeFix:
    """Return the terms of a keyframe without a fix."""
    none = np.zeros(3)
    return KeyframeFix(none, none, none, none, 0.0, none, np.zeros((3, 3)), none)


@dataclass(frozen=True, slots=True, eq=False)
class GnssMeasurements:
    """At ``t`` (n,) [s]: ``v_n`` [m/s] and ``p_n`` [m] with their sigmas (n, 3), inf where one is not used.

    ``rate_b`` (n, 3) [rad/s] is the IMU's, with its bias.
    """

    t: FloatArray
    v_n: FloatArray
    v_std: FloatArray
    p_n: FloatArray
    p_std: FloatArray
    rate_b: FloatArray

    def at_end(
        self, t0: float, part: Preintegrated, C_nb: FloatArray, pull: FloatArray, antenna: LeverArm
    ) -> KeyframeFix:
        """Return what all fixes since ``t0`` say at the end of ``part``.

        ``C_nb`` is the attitude at t0, ``pull`` (3,) [m/s2] gravity and Coriolis acceleration.
        """
        which = slice(*np.searchsorted(self.t, [t0, t0 + part.dt], "right"))
        since = self.t[which] - t0
        if not len(since):
            return no_fix()
        gained = interpolated(since, part.edges, part.dv_from)
        share = (since / part.dt)[:, None, None]
        C_1f = (1 - share) * part.turn.T + share * np.eye(3)  # of a lever arm, good enough within 0.1 s
        swing = C_1f @ skew(self.rate_b[which] - part.bg)
        v = self.v_n[which] + (part.dv - gained) @ C_nb.T + pull * (part.dt - since)[:, None]
        unsure = antenna.std**2 * np.sum(self.rate_b[which] ** 2, axis=1)
        v, v_weight = _mean(v, 1 / (self.v_std[which] ** 2 + unsure[:, None]))
        p, p_weight = _mean(self.p_n[which], self.p_std[which] ** -2)
        age, a = float(np.mean(since - part.dt)), pull + C_nb @ part.dv / part.dt
        return KeyframeFix(v, v_weight, p, p_weight, age, antenna.lever, swing.mean(axis=0), a)


def _mean(values: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the weighted mean of (n, 3), and its weight (3,)."""
    total = weight.sum(axis=0)
    return (weight * values).sum(axis=0) / np.maximum(total, 1e-12), total


def measurements(fixes: GnssFixes, imu: ImuSeries) -> GnssMeasurements:
    """Return what fixes say of velocity, and the IMU's rate at each; their positions are not used."""
    rate = interpolated(fixes.t, imu.t, imu.omega_b)
    stated = np.isfinite(fixes.v_n) & np.isfinite(fixes.velocity_std)[:, None]
    v, std = np.where(stated, fixes.v_n, 0.0), np.where(stated, fixes.velocity_std[:, None], np.inf)
    climb, climb_std = _climb(fixes)
    unstated = ~stated[:, 2] & np.isfinite(climb)
    v[unstated, 2], std[unstated, 2] = climb[unstated], climb_std[unstated]
    return GnssMeasurements(fixes.t, v, std, fixes.p_n, np.full(v.shape, np.inf), rate)


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
