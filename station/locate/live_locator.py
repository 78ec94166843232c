"""Where a unit is and which way it points while it is carried: samples, fixes and images in, a location out.

All follows from what came and from the moments at which it was read, so that a replay gives the same. Keyframes
stand at fixes, or at a camera's frames where there is one, as far behind the newest sample as fixes are late. What
comes later than those is not waited for: a camera's frames count at the keyframes that stand where they were
taken, which the window keeps for as long; a wheel's that are later are not used, and that is reported.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.pose_graph import GlobalPose, PoseGraphSettings
from procedures.geodesy import earth_rate_n, normal_gravity
from station.locate.camera_source import antenna_of, with_lever
from station.locate.imu_source import with_constants
from station.locate.live_alignment import (
    MAX_BUFFER_S,
    Graph,
    LiveAlignment,
    LiveGraph,
    LiveStart,
    NoGraph,
    joined_series,
)
from station.locate.live_camera import LiveCamera
from station.locate.live_fixes import KEYFRAME_DELAY_S, LiveFixes, LiveWheel, LocationReport
from station.locate.location import Location
from station.locate.monitor_interface import LocatorTick
from station.locate.outer_layer import FREE_ARM

TRY_EVERY_S = 1.0


class LiveLocator:
    """Call `take` for each tick; ``location`` is what is known then.

    ``noise_of`` samples is None as long as it is too early to report. ``ahead`` (3,) is forward in IMU axes;
    ``lever_arm`` (3,) [m] from IMU to antenna, None: estimated.
    """

    def __init__(
        self, noise_of: Callable[[ImuSeries], ImuNoise | None], ahead: FloatArray,
        lever_arm: FloatArray | None = None, camera: LiveCamera | None = None, wheel: LiveWheel | None = None,
    ) -> None:  # fmt: skip
        self._wheel = wheel
        self._noise_of, self._arm, self._report, self._camera = noise_of, lever_arm, LocationReport(ahead), camera
        self._given = LiveFixes()
        self.reset()

    def reset(self) -> None:
        """Begin again: the unit's time has no relation to what came before."""
        self._given = LiveFixes(self._given.origin)
        self._report.reset()
        if self._camera is not None:
            self._camera.reset()
        if self._wheel is not None:
            self._wheel.reset()
        self._imu: deque[ImuSeries] = deque()
        self._beginning: LiveAlignment | None = None
        self._window: InertialWindow | VisualInertialWindow | None = None
        self._graph: Graph | None = None
        self._try_at = -np.inf
        self.location = Location(why="no fix yet")

    def take(self, taken: LocatorTick) -> None:
        """Advance by a tick."""
        now = float(taken.imu.t[-1])
        self._keep(taken.imu, now)
        self._given.mark(taken.marks, taken.pulses)
        new = self._given.take(taken.records, now)
        if self._camera is not None:
            self._see(self._camera, taken, now)
        if self._wheel is not None:
            self._roll(self._wheel, taken, now)
        if self._window is not None and self._graph is not None:
            if new is not None:
                self._graph.add(new)
            self._go_on(self._window, self._graph, now)
        elif self._given.fixes is not None and now >= self._try_at:
            self._try_at = now + TRY_EVERY_S
            self._try_to_begin(self._given.fixes)

    def _keep(self, imu: ImuSeries, now: float) -> None:
        """Keep the samples that an alignment needs, or a camera's delay, or else the next keyframes."""
        self._imu.append(imu)
        is_learnt = self._window is not None and (self._camera is None or self._camera.offset is not None)
        while now - self._imu[0].t[-1] > (2 * KEYFRAME_DELAY_S[1] if is_learnt else MAX_BUFFER_S):
            self._imu.popleft()

    def _see(self, camera: LiveCamera, taken: LocatorTick, now: float) -> None:
        camera.mark(taken.marks)
        camera.take(taken.images, now)
        camera.dropped += taken.images_dropped
        if camera.is_due:
            camera.learn(joined_series(list(self._imu)))
        self.location = replace(self.location, camera=camera.text, images_dropped=camera.dropped)

    def _roll(self, wheel: LiveWheel, taken: LocatorTick, now: float) -> None:
        wheel.mark(taken.marks)
        wheel.take(taken.wheel, now)
        self.location = replace(self.location, wheel=wheel.text(self._window))

    def _try_to_begin(self, fixes: GnssFixes) -> None:
        imu = joined_series(list(self._imu))
        if self._beginning is None and (noise := self._noise_of(imu)) is not None:
            self._beginning = LiveAlignment(self._aligner(noise), self._camera)
        if self._beginning is None:
            begun, why = None, "keep it still for 10 s: its noise is measured"
        else:
            begun = self._beginning.attempt(imu, fixes)
            why = self._beginning.why
        self.location = replace(self.location, why=why, fixes=self._given.count)
        if begun is not None and self._beginning is not None:
            self._begin(begun, self._beginning.aligner, fixes)
            assert self._window is not None
            assert self._graph is not None
            self._go_on(self._window, self._graph, float(imu.t[-1]))  # frames may be late, the location is not

    def _begin(self, begun: LiveStart, a: MovingAligner, fixes: GnssFixes) -> None:
        """Go through the data of the alignment again."""
        given, site = PoseGraphSettings(lever_arm=self._arm), Site(a.gravity, a.earth_n, a.noise)
        wheel = None if self._wheel is None else self._wheel.aid(a.noise)
        window: InertialWindow | VisualInertialWindow
        if self._camera is None:
            given = with_constants(given, begun.aligned)
            # without a velocity by GNSS nothing would hold a window's velocity
            has_velocity = fixes.has_velocity.any()
            settings = WindowSettings(site, given.arm, 2 if has_velocity else 1, lever_std=a.lever_std)
            window = InertialWindow(settings, begun.imu, fixes, begun.aligned, wheel)
            graph: Graph = LiveGraph(given) if has_velocity else NoGraph(window)
        else:
            given = with_lever(replace(given, lever_arm_std=a.lever_std), begun.aligned)
            offset_std, tracks = self._camera.offset_std, self._camera.tracks(begun.aligned.t0)
            seeing = VisionSettings(site, self._camera.camera, antenna_of(given), offset_std=offset_std)
            window = VisualInertialWindow(seeing, begun.imu, tracks, fixes, begun.aligned, wheel)
            graph = LiveGraph(given)
        self._window, self._graph = window, graph
        graph.add(fixes)
        self._given.taken = 0
        for pose in window.poses():
            known = graph.take(pose)
            passed = self._given.passed(pose.t)
            if known is not None and pose.t >= begun.aligned.t:
                self._show(window.velocity, graph, known, passed)

    def _aligner(self, noise: ImuNoise) -> MovingAligner:
        origin = self._given.origin
        assert origin is not None
        gravity, earth_n = normal_gravity(origin.latitude, origin.height), earth_rate_n(origin.latitude)
        if self._arm is not None:
            return MovingAligner(noise, gravity, earth_n, self._arm)
        return MovingAligner(noise, gravity, earth_n, np.zeros(3), FREE_ARM)

    def _go_on(self, window: InertialWindow | VisualInertialWindow, graph: Graph, now: float) -> None:
        """Add the keyframes that are due."""
        since = window.t - 2 * KEYFRAME_DELAY_S[1]
        imu = joined_series([part for part in self._imu if part.t[-1] > since])
        for pose in self._due(window, imu, now - self._given.lateness):
            if (known := graph.take(pose)) is not None:
                self._show(window.velocity, graph, known, self._given.passed(pose.t))
                if self._arm is None and isinstance(window, VisualInertialWindow):  # the other one finds its own
                    window.antenna = LeverArm(graph.lever_arm, graph.lever_std)
        self._given.forget()

    def _due(
        self, window: InertialWindow | VisualInertialWindow, imu: ImuSeries, until: float
    ) -> Iterator[OdometryPose]:
        """Yield the keyframes that are due up to a time [s]; ``imu`` has the samples since the last one."""
        assert self._given.fixes is not None
        if isinstance(window, InertialWindow):
            while (t := self._given.next_keyframe(window.t, until)) is not None:
                yield window.go_on(t, imu, self._given.fixes)
        elif self._camera is not None:
            for late in self._camera.late(window.times, window.seen_until):
                window.see_late(late)
            lags = self._camera.lags(self._given.lateness)
            window.awaited = self._camera.awaited if lags else 0
            until = until if lags else min(until, float(imu.t[-1]) - self._camera.lateness)
            for frame in self._camera.due(window.t, until, lags=lags):
                yield window.go_on(frame, imu, self._given.fixes)
                self._camera.fitted = window.state.offset

    def _show(self, velocity: FloatArray, graph: Graph, pose: GlobalPose, passed: range) -> None:
        fixes, origin = self._given.fixes, self._given.origin
        assert fixes is not None
        assert origin is not None
        antenna = pose.p + pose.C_nb @ graph.lever_arm
        for fix in passed:
            place = antenna - velocity * (pose.t - fixes.t[fix])
            self._report.look_at(place, float(fixes.position_std[fix]), fixes.p_n[fix])
        camera, dropped = ("", 0) if self._camera is None else (self._camera.text, self._camera.dropped)
        wheel = "" if self._wheel is None else self._wheel.text(self._window)
        location = self._report.location(pose, velocity, origin, self._given)
        self.location = replace(location, camera=camera, images_dropped=dropped, wheel=wheel)
