"""Live attitude by the joint (Kalman) filter: the noise from the first seconds, then tick by tick.

Without aid, `VehicleWatch` decides whether the unit moves as a vehicle does; the filter then continues with the
uncertainty that it has. As of a log (`unaided_motion`), but from the last seconds of motion.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, inclination, roll_pitch_of
from procedures.attitude.kalman.kalman_filter import AttitudeKalmanFilter
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.unaided_motion import MIN_MOTION_S, VEHICLE_RUNS, settings_in_vehicle
from procedures.units import DEG_H_PER_RAD_S
from station.attitude.live_readings import AttitudeReading
from station.calibrated.rates_and_forces import RatesAndForces

# times the noise assumed, over `MIN_MOTION_S`: 0.55 m/s*sqrt(s), where hands reach 0.40 and a calm ship 0.74
DRIFT_LIMIT = 2.5
MAX_TICKS = 600  # that are kept: a minute


class VehicleWatch:
    """Follows a filter tick by tick; ``in_vehicle`` makes a vehicle's settings of a room's."""

    def __init__(self, in_vehicle: Callable[[KalmanSettings], KalmanSettings]) -> None:
        self._in_vehicle = in_vehicle
        self.is_vehicle = False
        self._rest: AttitudeKalmanFilter | None = None  # as it was at the end of the last one
        self._since = list[AttitudeLog]()
        self._seen = deque[tuple[float, float]]()  # seconds of motion, and what the velocity drifted, squared

    def reset(self) -> None:
        """Forget what came before: time restarts."""
        self._rest = None
        self._since.clear()
        self._seen.clear()

    def follow(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> AttitudeKalmanFilter:
        """Take a tick that ``kept`` has filtered; return the filter to continue with."""
        if self.is_vehicle:
            if kept.state.memory[0].drift_time >= MIN_MOTION_S:
                kept.settings = settings_in_vehicle(kept)
            return kept
        self._keep(kept, log)
        if not self._drifts(kept):
            return kept
        self.is_vehicle = True
        found = self._filtered_again(self._in_vehicle(kept.settings))
        self.reset()
        return found

    def _keep(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> None:
        if kept.at_rest:
            self._rest, self._since = kept.copy(), []
            return
        self._since.append(log)
        if len(self._since) > MAX_TICKS:
            self._rest = None
            del self._since[: MAX_TICKS // 2]

    def _drifts(self, kept: AttitudeKalmanFilter) -> bool:
        memory = kept.state.memory[0]
        now, squared = float(memory.drift_time), float(memory.drift_squared)
        if self._seen and now < self._seen[-1][0]:  # it was aligned again
            self._seen.clear()
        self._seen.append((now, squared))
        while len(self._seen) > 1 and self._seen[1][0] <= now - MIN_MOTION_S:
            self._seen.popleft()
        lasted = now - self._seen[0][0]
        if lasted < MIN_MOTION_S:
            return False
        return math.sqrt((squared - self._seen[0][1]) / lasted) > DRIFT_LIMIT * kept.settings.speed_noise

    def _filtered_again(self, settings: KalmanSettings) -> AttitudeKalmanFilter:
        log = joined(self._since)
        for _ in range(VEHICLE_RUNS + 1):
            found = AttitudeKalmanFilter("none") if self._rest is None else self._rest.copy()
            found.forget_motion()
            found.settings = settings
            found.run(log)
            settings = settings_in_vehicle(found)
        return found


def aided_at_end(
    t: FloatArray, inputs: RatesAndForces, airspeed: float, velocity: Sequence[float], heading: float
) -> AttitudeLog:
    """Return samples that end at ``t`` (n,) [s], with the aid of the last one: m/s, m/s north-east-down, rad."""
    aids = np.full((len(t), 5), np.nan)
    aids[-1] = airspeed, *velocity, heading
    return AttitudeLog(t, inputs.rate, inputs.force, aids[:, 0].copy(), aids[:, 1:4].copy(), aids[:, 4].copy())


def joined(logs: Sequence[AttitudeLog]) -> AttitudeLog:
    """Return logs one after the other as one."""
    names = ("t", "omega_b", "f_b", "airspeed", "velocity", "heading")
    return AttitudeLog(**{name: np.concatenate([getattr(log, name) for log in logs]) for name in names})


ALIGN_S = 2.0
# of rest, from which north is stated: a little more than `procedures.attitude.kalman.unaided_motion` asks for
NORTH_S = 31.0
RESIDUAL_SHARE = 0.1  # of each tick: a second
# put between what has no relation in time: the filter then restarts with the biases learnt
RESTART_GAP_S = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class AidValues:
    """An aid's newest values, nan where there is none: ``airspeed`` [m/s], ``velocity`` (3,) NED, ``heading``.

    ``age`` [s] of velocity and heading at the tick's end.
    """

    airspeed: float = np.nan
    velocity: tuple[float, float, float] = (np.nan, np.nan, np.nan)
    heading: float = np.nan
    age: float = 0.0


NO_AID = AidValues()
Compass = Callable[[AttitudeLog], tuple[float, float] | None]


class AttitudeEstimator:
    """One unit's attitude.

    ``settings`` makes the filter's of some seconds and of whether the heading is known. Where it is not,
    ``compass`` may give heading and 1 sigma [rad] of half a minute's rest; the filter then goes through that rest
    again, knowing it, and ``north`` holds what was found. Without aid ``in_vehicle`` makes settings those of a
    vehicle once it moves as one; where it is None it is taken to stay in a room.
    """

    def __init__(
        self, aid: str, settings: Callable[[AttitudeLog, bool], KalmanSettings], heading: float = np.nan,
        compass: Compass | None = None, in_vehicle: Callable[[KalmanSettings], KalmanSettings] | None = None,
    ) -> None:  # fmt: skip
        self._aid, self._settings, self._heading, self._compass = aid, settings, heading, compass
        self._watch = None if in_vehicle is None or aid != "none" else VehicleWatch(in_vehicle)
        self.north: tuple[float, float] | None = None
        self._rest: list[AttitudeLog] = []
        self._first: list[AttitudeLog] = []  # seconds to learn the noise from
        self._filter: AttitudeKalmanFilter | None = None
        self._shift = 0.0  # of the device's time, so that it continues
        self._last: float | None = None
        self._force: FloatArray | None = None  # smoothed over a second

    def reset(self) -> None:
        """Take the next tick's time as one of another beginning."""
        self._first.clear()
        if self._watch is not None:
            self._watch.reset()
        if self._filter is None:
            self._last = None
        else:
            self._rest.clear()
            self._shift = np.nan

    def take(self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues = NO_AID) -> AttitudeReading | None:
        """Take ends ``t`` (n,) [s] and inputs of a tick; None while aligning. The aid is of the last sample."""
        if np.isnan(self._shift):
            assert self._last is not None
            self._shift = self._last + RESTART_GAP_S - float(t[0])
        log = self._log(t + self._shift, inputs, aiding)
        self._last = float(log.t[-1])
        if self._filter is None:
            self._first.append(log)
            if self._last - self._first[0].t[0] < ALIGN_S:
                return None
            log = joined(self._first)
            self._filter = AttitudeKalmanFilter(self._aid, self._settings(log, bool(np.isfinite(self._heading))))
            self._first.clear()
        self._filter.settings = self._filter.settings._replace(fix_latency=aiding.age)
        self._filter.run(log)
        if self._watch is not None:
            self._filter = self._watch.follow(self._filter, log)
        if not self.is_vehicle:
            self._learn_noise(self._filter, log)
        return self._found(self._find_north(self._filter, log), float(t[-1]), inputs)

    @property
    def is_vehicle(self) -> bool:
        """Whether it has moved as a vehicle does, so that gyros alone determine its attitude."""
        return self._watch is not None and self._watch.is_vehicle

    @property
    def smoothed_force(self) -> FloatArray:
        """The specific force (3,) [m/s2] smoothed over a second."""
        assert self._force is not None
        return self._force

    def _learn_noise(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> None:
        """Take the noise of a rest if it is less than what was seen so far: the first seconds may have moved."""
        if not kept.at_rest:
            self._first.clear()
            return
        self._first.append(log)
        if log.t[-1] - self._first[0].t[0] < ALIGN_S:
            return
        seen, now = self._settings(joined(self._first), False), kept.settings
        self._first.clear()
        names = ("gyro_noise", "rest_force_noise")
        kept.settings = now._replace(**{name: min(getattr(now, name), getattr(seen, name)) for name in names})

    def _find_north(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> AttitudeKalmanFilter:
        """Return the filter to continue with: one that knows north where this rest has determined it."""
        if self._compass is None or kept.state.memory[0].heading_known > 0:
            return kept
        self._rest = [*self._rest, log] if kept.at_rest else []
        if not self._rest or log.t[-1] - self._rest[0].t[0] < NORTH_S:
            return kept
        whole, self._rest = joined(self._rest), []
        if (found := self._compass(whole)) is None:
            return kept
        assert whole.heading is not None
        whole.heading[0], std = self.north = found
        self._filter = AttitudeKalmanFilter(self._aid, self._settings(whole, True)._replace(heading_std=std))
        self._filter.run(whole)
        return self._filter

    def _log(self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues) -> AttitudeLog:
        heading = aiding.heading + aiding.age * self._turning(inputs)
        log = aided_at_end(t, inputs, aiding.airspeed, aiding.velocity, heading)
        if self._last is None and np.isnan(aiding.heading):
            assert log.heading is not None
            log.heading[0] = self._heading
        return log

    def _turning(self, inputs: RatesAndForces) -> float:
        """Return the rate of the heading [rad/s]; zero while aligning."""
        return 0.0 if self._filter is None else float(self._filter.down @ inputs.rate.mean(axis=0))

    def _found(self, kept: AttitudeKalmanFilter, t: float, inputs: RatesAndForces) -> AttitudeReading:
        C, knows = kept.state.C_nb, kept.state.memory[0].heading_known > 0
        p, q, r = np.degrees(inputs.rate.mean(axis=0)).tolist()
        x, y, z = (kept.gyro_bias[0] * DEG_H_PER_RAD_S).tolist()
        angles = *roll_pitch_of(kept.down), kept.sigma, inclination(-self._smoothed(inputs.force), kept.down)
        roll, pitch, sigma, residual = np.degrees(np.array(angles)).tolist()
        return AttitudeReading(
            t, roll, pitch, sigma, (p, q, r), (x, y, z), residual, "at rest" if kept.at_rest else "moving",
            float(np.degrees(np.arctan2(C[1, 0], C[0, 0]))) if knows else None,
        )  # fmt: skip

    def _smoothed(self, force: FloatArray) -> FloatArray:
        """Return the specific force (3,) smoothed: of one tick it shows the counter's step more than anything."""
        now: FloatArray = force.mean(axis=0)
        self._force = now if self._force is None else self._force + RESIDUAL_SHARE * (now - self._force)
        return self._force


def compile_filter() -> None:
    """Have the filter compiled: kept on the disk, so that only a first run of all takes its minute."""
    t: FloatArray = np.arange(10.0)
    still = RatesAndForces(np.zeros((10, 3)), np.tile([0.0, 0.0, -9.8], (10, 1)))
    track = AttitudeEstimator("none", lambda log, knows: KalmanSettings())
    track.take(t, still)
