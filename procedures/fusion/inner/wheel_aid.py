"""A wheel with an IMU: what it says at each keyframe, whether it slips, whether the vehicle stands.

*Slip* is disagreement with what IMU and GNSS predict, by the sigma of both: of one keyframe alone, or of the mean
of the last half second, in which a slow slip shows. From then on the wheel is not used, nor what it measured in
the second before, until it has agreed for half a second. The limits widen with the time that it lasts: a window
that was too sure of itself comes back to the wheel. *At rest* the wheel measures zero, and rates and specific
forces do not change; then velocity is zero in all three axes.
"""

from collections import deque
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import skew
from procedures.fusion.fusion_records import ImuNoise, ImuSeries, KeyframeWheel, WheelMount, WheelSpeeds
from procedures.fusion.inner.window_problem import WindowMeasurements
from procedures.fusion.inner.window_state import WHEEL, Factor
from procedures.fusion.inner.window_terms import at_end
from procedures.fusion.preintegration import Preintegrated

SLIP_SIGMAS = 4.0  # of one keyframe: 6e-5 by chance
CREEP_SIGMAS = 4.5  # of the mean of `MEMORY_S`
MEMORY_S = 0.5  # s
RETRACTED_S = 1.0  # s before a slip was seen, in which the wheel is not believed either
WIDENING_S = 10.0  # s of slip after which the limits are twice as wide
MIN_MEASURED_SPEED = 0.5  # m/s below which many a wheel's sensor measures zero
REST_S = 0.5  # s in which nothing changes at rest
REST_PARTS = 5  # means that are compared
REST_FORCE, REST_RATE = 0.08, 0.01  # m/s2 and rad/s by which they may differ beyond their noise: an engine, wind
REST_SIGMAS = 4.0
REST_STD = 0.01  # m/s of each axis of a vehicle that stands
MAX_REST_SPEED_ERROR = 1.0  # m/s, with five sigmas, of a velocity predicted that may be zero all the same


class WheelAid:
    """Call `measured` and `judged` for each keyframe in turn. ``slips``: from when to when [s] it slipped.

    ``late`` [s] is how long after its keyframe the newest speed came that came too late to be used; 0 where it was
    in time.
    """

    def __init__(self, mount: WheelMount, speeds: WheelSpeeds, noise: ImuNoise) -> None:
        self.mount, self.speeds, self._noise = mount, speeds, noise
        self.slips = list[tuple[float, float]]()
        self.rest_s = 0.0  # s at rest, so far
        self.late = 0.0
        self._until = -np.inf  # the newest keyframe [s]
        self._slipping_since: float | None = None
        self._agreed = 0.0  # s since the last disagreement
        self._recent: deque[tuple[float, float]] = deque()  # times and whitened differences of `MEMORY_S`

    @property
    def slips_now(self) -> bool:
        """Whether the wheel is not believed at the newest keyframe."""
        return self._slipping_since is not None

    def add(self, more: WheelSpeeds) -> None:
        """Take speeds that came later, and let go those that are of no more use."""
        if len(more.t):
            self.late = max(0.0, self._until - float(more.t[-1]))
        self.speeds = self.speeds.followed_by(more)
        if len(self.speeds.t) > 4000:
            self.speeds = self.speeds.since(float(self.speeds.t[-1]) - 20.0)

    def measured(self, t0: float, part: Preintegrated, pull_b: FloatArray) -> KeyframeWheel | None:
        """Return what the wheel measured since ``t0`` [s], at the end of ``part``.

        ``pull_b`` (3,) [m/s2] is gravity and Coriolis acceleration in the axes at the end.
        """
        self._until = t0 + part.dt
        first, last = np.searchsorted(self.speeds.t, [t0, self._until], "right")
        speeds = WheelSpeeds(self.speeds.t[first:last], self.speeds.speed[first:last])
        return at_end(speeds, self.mount, t0, part, pull_b)

    def judged(
        self, seen: KeyframeWheel, t: float, dt: float, v_b: FloatArray, scale: float, P: FloatArray,
        imu: ImuSeries,
    ) -> KeyframeWheel:  # fmt: skip
        """Return a keyframe's wheel as far as it is believed.

        Parameters
        ----------
        t, dt : time of the keyframe, and since the one before [s]
        v_b : (3,), velocity [m/s] predicted, body
        scale : the wheel's scale factor, as it is known
        P : (4, 4), covariance of v_b and scale
        imu : samples of the last `REST_S` at least
        """
        if self._stands(t, seen, v_b, P, imu):
            self._end_slip(t)
            self.rest_s += dt
            return replace(seen, weight=0.0, rest_weight=REST_STD**-2)
        off, variance, seen = self._compared(seen, v_b, scale, P)
        if self._disagrees(t, dt, off, variance):
            self._agreed = 0.0
            if self._slipping_since is None:
                self._slipping_since = t
        else:
            self._agreed += dt
            if self._agreed >= MEMORY_S:
                self._end_slip(t)
        return replace(seen, weight=0.0) if self.slips_now else seen

    def _compared(
        self, seen: KeyframeWheel, v_b: FloatArray, scale: float, P: FloatArray
    ) -> tuple[float, float, KeyframeWheel]:
        """Return the wheel's speed less the predicted one [m/s], its variance, and the wheel with its sign."""
        predicted = float(seen.along @ v_b) - seen.due
        if not self.mount.is_signed and abs(-scale * seen.speed - predicted) < abs(scale * seen.speed - predicted):
            seen = replace(seen, speed=-seen.speed)
        if seen.speed == 0.0:
            seen = replace(seen, weight=1 / (1 / seen.weight + MIN_MEASURED_SPEED**2))
        pick = np.r_[seen.along, -seen.speed]
        return scale * seen.speed - predicted, float(pick @ P @ pick) + 1 / seen.weight, seen

    def _disagrees(self, t: float, dt: float, off: float, variance: float) -> bool:
        lasted = 0.0 if self._slipping_since is None else t - self._slipping_since
        whitened = off / (np.sqrt(variance) * (1 + lasted / WIDENING_S))
        self._recent.append((t, float(np.clip(whitened, -SLIP_SIGMAS, SLIP_SIGMAS))))
        while self._recent[0][0] <= t - MEMORY_S:
            self._recent.popleft()
        creep = sum(each for _, each in self._recent) / np.sqrt(len(self._recent))
        return bool(abs(whitened) > SLIP_SIGMAS or abs(creep) > CREEP_SIGMAS)

    def _end_slip(self, t: float) -> None:
        if self._slipping_since is not None and t - self._agreed > self._slipping_since:  # one alone is an outlier
            self.slips.append((self._slipping_since, t - self._agreed))
        self._slipping_since = None

    def _stands(self, t: float, seen: KeyframeWheel, v_b: FloatArray, P: FloatArray, imu: ImuSeries) -> bool:
        first, last = np.searchsorted(self.speeds.t, [t - REST_S, t], "right")
        speeds = self.speeds.speed[first:last]
        if seen.speed or not len(speeds) or speeds.any() or self.speeds.t[first] > t - REST_S / 2:
            return False
        std = np.sqrt(np.trace(P[:3, :3]))
        return bool(np.linalg.norm(v_b) < MAX_REST_SPEED_ERROR + 5 * std) and self._is_quiet(t, imu)

    def _is_quiet(self, t: float, imu: ImuSeries) -> bool:
        """Say whether the means of parts of the last `REST_S` differ by no more than at rest."""
        first, last = np.searchsorted(imu.t, [t - REST_S, t], "right")
        if last - first < 2 * REST_PARTS or imu.t[first] > t - 0.8 * REST_S:
            return False
        part = np.sqrt(REST_PARTS / REST_S)  # a mean of white noise of density 1 over such a part
        triads = ((imu.f_b, self._noise.accel, REST_FORCE), (imu.omega_b, self._noise.gyro, REST_RATE))
        for values, density, allowed in triads:
            means = np.array([each.mean(axis=0) for each in np.array_split(values[first:last], REST_PARTS)])
            if np.ptp(means, axis=0).max() > REST_SIGMAS * density * part + allowed:
                return False
        return True


def predicted_covariance(
    factor: Factor, at: int, C_ob: FloatArray, v_b: FloatArray, noise: ImuNoise, dt: float
) -> FloatArray:
    """Return the covariance (4, 4) of a velocity predicted, body axes [m/s], and of the wheel's scale factor.

    Parameters
    ----------
    factor : of the keyframes before, of which the last begins ``at`` in the state
    C_ob, v_b : (3, 3) and (3,), attitude and velocity [m/s] predicted, body
    dt : s of IMU since the last of them
    """
    pick = np.zeros((factor.size, 4))
    pick[at : at + 3, :3], pick[at + 6 : at + 9, :3] = skew(v_b).T, C_ob
    pick[WHEEL, 3] = 1.0
    P: FloatArray = pick.T @ factor.solve(pick)
    P[range(3), range(3)] += noise.accel**2 * dt
    return P


def without_wheel(held: WindowMeasurements, newest: float, seconds: float) -> WindowMeasurements:
    """Return what ties the keyframes without the wheel of the last ``seconds``, ``newest`` [s] on top."""
    ages = np.r_[newest + np.cumsum([part.dt for part in held.parts][::-1])[::-1], newest]
    fixes = [replace(fix, wheel=None) if age < seconds else fix for fix, age in zip(held.fixes, ages, strict=True)]
    return WindowMeasurements(held.parts, fixes)
