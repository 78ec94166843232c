"""Whether a live unit without aid moves as a vehicle does, and the filter that goes on then with the sigma it has.

As of a log (`procedures.attitude.unaided_motion`), but of the last seconds of motion. What came since the last
rest is filtered again as a vehicle's, from the state of that rest: by then the filter of a room has taken
accelerations for tilts. Then the noise of its speed is what it shows. It stays a vehicle until the monitor ends.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.kalman_state import KalmanSettings
from procedures.attitude.roll_pitch_kalman_filter import AttitudeKalmanFilter
from procedures.attitude.unaided_motion import LEAST_MOTION_S, VEHICLE_RUNS, with_own_speed

# times the noise assumed, over `LEAST_MOTION_S`: 0.55 m/s*sqrt(s), where hands reach 0.40 and a calm ship 0.74
WANDER_LIMIT = 2.5
MAX_TICKS = 600  # that are kept: a minute


class VehicleWatch:
    """Follows a filter tick by tick; ``in_vehicle`` makes a vehicle's settings of a room's."""

    def __init__(self, in_vehicle: Callable[[KalmanSettings], KalmanSettings]) -> None:
        self._in_vehicle = in_vehicle
        self.is_vehicle = False
        self._rest: AttitudeKalmanFilter | None = None  # as it was at the end of the last one
        self._since = list[AttitudeLog]()
        self._seen = deque[tuple[float, float]]()  # seconds of motion, and what the velocity wandered, squared

    def begin_anew(self) -> None:
        """Forget what came before: time begins anew."""
        self._rest = None
        self._since.clear()
        self._seen.clear()

    def follow(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> AttitudeKalmanFilter:
        """Take a tick that ``kept`` has filtered; return the filter to go on with."""
        if self.is_vehicle:
            if kept.state.memory[0].wander_time >= LEAST_MOTION_S:
                kept.settings = with_own_speed(kept)
            return kept
        self._keep(kept, log)
        if not self._wanders(kept):
            return kept
        self.is_vehicle = True
        found = self._filtered_again(self._in_vehicle(kept.settings))
        self.begin_anew()
        return found

    def _keep(self, kept: AttitudeKalmanFilter, log: AttitudeLog) -> None:
        if kept.at_rest:
            self._rest, self._since = kept.copy(), []
            return
        self._since.append(log)
        if len(self._since) > MAX_TICKS:
            self._rest = None
            del self._since[: MAX_TICKS // 2]

    def _wanders(self, kept: AttitudeKalmanFilter) -> bool:
        memory = kept.state.memory[0]
        now, squared = float(memory.wander_time), float(memory.wander_squared)
        if self._seen and now < self._seen[-1][0]:  # it was aligned anew
            self._seen.clear()
        self._seen.append((now, squared))
        while len(self._seen) > 1 and self._seen[1][0] <= now - LEAST_MOTION_S:
            self._seen.popleft()
        lasted = now - self._seen[0][0]
        if lasted < LEAST_MOTION_S:
            return False
        return math.sqrt((squared - self._seen[0][1]) / lasted) > WANDER_LIMIT * kept.settings.speed_noise

    def _filtered_again(self, settings: KalmanSettings) -> AttitudeKalmanFilter:
        log = joined(self._since)
        for _ in range(VEHICLE_RUNS + 1):
            found = AttitudeKalmanFilter("none") if self._rest is None else self._rest.copy()
            found.forget_motion()
            found.settings = settings
            found.run(log)
            settings = with_own_speed(found)
        return found


def joined(logs: Sequence[AttitudeLog]) -> AttitudeLog:
    """Return logs one after the other as one."""
    names = ("t", "omega_b", "f_b", "airspeed", "velocity", "heading")
    return AttitudeLog(**{name: np.concatenate([getattr(log, name) for log in logs]) for name in names})
