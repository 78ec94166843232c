"""Where a unit is and which way it points while it is carried: samples and fixes in, a location out.

All follows from the samples, the fixes and the moments at which both were read, so that a replay gives the same.
A keyframe stands at each fix and at least every 50 ms, as far behind the newest sample as fixes are late.
"""

from collections import deque

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth import earth_rate_n, normal_gravity
from procedures.fusion.inertial_window import WindowSettings
from procedures.fusion.live_window import LiveWindow
from procedures.fusion.moving_aligner import MovingAligner
from procedures.fusion.outer_graph import GlobalPose, OuterSettings
from procedures.fusion.records import GnssFixes, ImuNoise, ImuSeries
from station.locate.imu_noise import NoiseOf
from station.locate.inertial import with_constants
from station.locate.live_beginning import KEPT, Beginning, Begun, joined
from station.locate.live_fixes import BEHIND, LiveFixes
from station.locate.live_graph import LiveGraph
from station.locate.live_told import Told
from station.locate.taken import Taken
from station.locate.through_graph import FREE_ARM
from station.monitor.view import Location

TRY_EVERY_S = 1.0


class LiveLocator:
    """Call `take` for each tick; ``location`` is what is known then.

    ``ahead`` (3,) is forward in IMU axes; ``lever_arm`` (3,) [m] from IMU to antenna, None: estimated.
    """

    def __init__(self, noise_of: NoiseOf, ahead: FloatArray, lever_arm: FloatArray | None = None) -> None:
        self._noise_of, self._arm, self._told = noise_of, lever_arm, Told(ahead)
        self._given = LiveFixes()
        self.begin_anew()

    def begin_anew(self) -> None:
        """Begin again: the unit's time has no relation to what came before."""
        self._given = LiveFixes(self._given.origin)
        self._told.begin_anew()
        self._imu: deque[ImuSeries] = deque()
        self._beginning: Beginning | None = None
        self._window: LiveWindow | None = None
        self._graph: LiveGraph | None = None
        self._try_at = -np.inf
        self.location = Location(why="no fix yet")

    def take(self, taken: Taken) -> None:
        """Go on by a tick."""
        now = float(taken.imu.t[-1])
        self._imu.append(taken.imu)
        while now - self._imu[0].t[-1] > (KEPT if self._window is None else 2 * BEHIND[1]):
            self._imu.popleft()
        self._given.mark(taken.marks)
        new = self._given.take(taken.records, now)
        if self._window is not None and self._graph is not None:
            if new is not None:
                self._graph.add(new)
            self._go_on(self._window, self._graph, now)
        elif self._given.fixes is not None and now >= self._try_at:
            self._try_at = now + TRY_EVERY_S
            self._try_to_begin(self._given.fixes)

    def _try_to_begin(self, fixes: GnssFixes) -> None:
        imu = joined(list(self._imu))
        begun = None
        if self._beginning is None and (noise := self._noise_of(imu)) is not None:
            self._beginning = Beginning(self._aligner(noise))
        if not np.isfinite(fixes.v_n[:, 0]).any():
            why = "the receiver tells no speed and course, which it needs"
        elif self._beginning is None:
            why = "keep it still for 10 s: its noise is learnt"
        else:
            begun = self._beginning.attempt(imu, fixes)
            why = self._beginning.why
        self.location = Location(why=why, fixes=self._given.count)
        if begun is not None and self._beginning is not None:
            self._begin(begun, self._aligner(self._beginning.noise), fixes)

    def _begin(self, begun: Begun, a: MovingAligner, fixes: GnssFixes) -> None:
        """Go through the data of the alignment again."""
        given = with_constants(OuterSettings(lever_arm=self._arm), begun.aligned)
        settings = WindowSettings(a.noise, a.gravity, a.earth_n, given.arm, lever_std=a.lever_std)
        self._window, self._graph = LiveWindow(settings, begun.imu, begun.fixes, begun.aligned), LiveGraph(given)
        self._graph.add(fixes)
        self._given.taken = len(fixes.t)
        for k, pose in enumerate(self._window.poses()):
            if (known := self._graph.take(pose)) is not None and pose.t >= begun.aligned.t:
                self._show(self._window, self._graph, known, int(self._window.frames.fix[k]))

    def _aligner(self, noise: ImuNoise) -> MovingAligner:
        origin = self._given.origin
        assert origin is not None
        gravity, earth_n = normal_gravity(origin.latitude, origin.height), earth_rate_n(origin.latitude)
        if self._arm is not None:
            return MovingAligner(noise, gravity, earth_n, self._arm)
        return MovingAligner(noise, gravity, earth_n, np.zeros(3), FREE_ARM)

    def _go_on(self, window: LiveWindow, graph: LiveGraph, now: float) -> None:
        """Add the keyframes that are due."""
        imu, until, fixes = joined(list(self._imu)), now - self._given.lateness, self._given.fixes
        assert fixes is not None
        while (due := self._given.next_keyframe(float(window.frames.t[-1]), until)) is not None:
            t, fix = due
            if (known := graph.take(window.go_on(t, imu, fixes, fix))) is not None:
                self._show(window, graph, known, fix)
        self._given.forget()

    def _show(self, window: LiveWindow, graph: LiveGraph, pose: GlobalPose, fix: int) -> None:
        fixes, origin = self._given.fixes, self._given.origin
        assert fixes is not None
        assert origin is not None
        if fix >= 0:
            antenna = pose.p + pose.C_nb @ graph.lever_arm
            self._told.look_at(antenna, float(fixes.position_std[fix]), fixes.p_n[fix])
        self.location = self._told.location(pose, window, origin, self._given)
