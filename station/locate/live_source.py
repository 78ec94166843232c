"""What a live locator draws poses from: the window in which alignment, samples and fixes come together."""

from collections.abc import Iterator
from typing import Protocol

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.odometry import OdometryPose
from station.locate.live_alignment import LiveStart
from station.locate.live_fixes import LiveFixes


class LiveSource(Protocol):
    """Go through `begin` first, then through what is `due` for ever."""

    @property
    def velocity(self) -> FloatArray:
        """The newest keyframe's velocity (3,) [m/s] in n."""
        ...

    def begin(self) -> Iterator[OdometryPose]:
        """Yield the poses of the alignment's own data."""
        ...

    def due(self, imu: ImuSeries, until: float) -> Iterator[OdometryPose]:
        """Yield the keyframes that are due up to a time [s]; ``imu`` has the samples since the last one."""
        ...

    def learn(self, lever: FloatArray, std: float) -> None:
        """Take the lever arm (3,) [m] and 1 sigma of it, as the graph knows them now."""
        ...


class LiveInertial:
    """IMU and GNSS velocity: `LiveSource` with a keyframe at each fix and between them."""

    def __init__(self, settings: WindowSettings, begun: LiveStart, given: LiveFixes) -> None:
        self.window, self._given = InertialWindow(settings, begun.imu, begun.fixes, begun.aligned), given

    @property
    def velocity(self) -> FloatArray:
        """The newest keyframe's velocity (3,) [m/s] in n."""
        return self.window.velocity

    def begin(self) -> Iterator[OdometryPose]:  # noqa: D102
        yield from self.window.poses()

    def due(self, imu: ImuSeries, until: float) -> Iterator[OdometryPose]:  # noqa: D102
        while (due := self._given.next_keyframe(self.window.t, until)) is not None:
            assert self._given.fixes is not None
            yield self.window.go_on(due, imu, self._given.fixes)

    def learn(self, lever: FloatArray, std: float) -> None:
        """Leave the ``lever`` arm (3,) [m]: this window estimates it itself."""
