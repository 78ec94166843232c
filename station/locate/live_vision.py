"""Locating live by a camera as well: when it may begin, and the window that it goes on in."""

from collections.abc import Iterator

from procedures.arrays import FloatArray
from procedures.fusion.alignment.alignment_attempts import between
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries
from procedures.fusion.imu.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.outer.pose_graph import PoseGraphSettings
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner
from procedures.fusion.visual_alignment.visual_start import VisualStart
from station.locate.camera_source import antenna_of
from station.locate.live_alignment import LiveAlignment, LiveStart
from station.locate.live_camera import LiveCamera
from station.locate.live_fixes import LiveFixes

LEAD_S = 1.0  # s of samples before the first keyframe


class LiveVisualAlignment:
    """Tries by the camera, and by the IMU alone where that cannot do it yet; ``why`` says what both miss."""

    def __init__(self, aligner: MovingAligner, camera: LiveCamera) -> None:
        self._inertial, self._camera = LiveAlignment(aligner), camera
        site = Site(aligner.gravity, aligner.earth_n, aligner.noise)
        antenna = LeverArm(aligner.lever, aligner.lever_std or 0.0)
        self._aligner = VisualAligner(VisionSettings(site, camera.camera, antenna))
        self.why = self._inertial.why

    @property
    def noise(self) -> ImuNoise:
        """The IMU's noise."""
        return self._inertial.noise

    def attempt(self, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | None:
        """Return a beginning if it is time for an attempt and that succeeds."""
        if (begun := self._by_camera(imu, fixes)) is not None:
            return begun
        begun = self._inertial.attempt(imu, fixes)
        self.why = f"{self.why}; without the camera: {self._inertial.why}"
        return begun

    def _by_camera(self, imu: ImuSeries, fixes: GnssFixes) -> LiveStart | None:
        tracks = self._camera.tracks()
        if not len(tracks.t):
            self.why = f"camera: {self._camera.why}"
            return None
        now = min(float(tracks.t[-1]), float(imu.t[-1]), float(fixes.t[-1]))
        found = self._aligner.align(imu, tracks, fixes, now)
        if not isinstance(found, VisualStart):
            self.why = found.why
            return None
        aligned = found.aligned
        return LiveStart(aligned, between(imu, aligned.t0 - LEAD_S, float(tracks.t[-1])), fixes)


class LiveVision:
    """Camera, IMU and GNSS velocity: `station.locate.live_source.LiveSource` with a keyframe at each frame."""

    def __init__(
        self, site: Site, given: PoseGraphSettings, begun: LiveStart, fixes: LiveFixes, camera: LiveCamera
    ) -> None:
        settings = VisionSettings(site, camera.camera, antenna_of(given), offset_std=camera.offset_std)
        tracks = camera.tracks(begun.aligned.t0)
        self._window = VisualInertialWindow(settings, begun.imu, tracks, begun.fixes, begun.aligned)
        self._camera, self._fixes = camera, fixes

    @property
    def velocity(self) -> FloatArray:
        """The newest keyframe's velocity (3,) [m/s] in n."""
        return self._window.velocity

    def begin(self) -> Iterator[OdometryPose]:  # noqa: D102
        yield from self._window.poses()

    def due(self, imu: ImuSeries, until: float) -> Iterator[OdometryPose]:  # noqa: D102
        for frame in self._camera.due(self._window.t, min(until, float(imu.t[-1]) - self._camera.lateness)):
            assert self._fixes.fixes is not None
            yield self._window.go_on(frame, imu, self._fixes.fixes)
            self._camera.fitted = self._window.state.offset

    def learn(self, lever: FloatArray, std: float) -> None:
        """Take the ``lever`` arm (3,) [m] and 1 sigma of it [m]."""
        self._window.antenna = LeverArm(lever, std)
