"""A camera on a simulated drive in memory: what it would follow, read at the IMU's own time, and late."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from drivers.camera import CameraImage
from drivers.simulated.vehicle_track import MIN_SPEED_M_S, VehicleTrack
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import Trajectory
from station.stream.camera import FeaturePositions
from station.stream.stream_events import StreamState
from tests.drivers.simulated.camera_tracks import View, simulate_tracks
from tests.station.stream.live.bench_in_memory import Source

# it looks ahead and 60 deg to the left, level
C_BC = np.array([[np.sqrt(0.75), 0.0, 0.5], [-0.5, 0.0, np.sqrt(0.75)], [0.0, -1.0, 0.0]])
CAMERA = PinholeCamera(230.0, 230.0, 187.5, 119.5, 0.5, C_BC, np.array([0.1, -0.05, 0.02]))
VIEW = View(width=376, height=240, features=80, depths=(3.0, 15.0), longest=6.0)


def driven(track: VehicleTrack) -> Trajectory:
    """Return where the IMU is at 20 Hz: x ahead, z up."""
    t = np.arange(track.t[0], track.t[-1], 0.05)
    v = track.velocities(t)
    moves = np.hypot(v[:, 0], v[:, 1]) > MIN_SPEED_M_S
    course = np.interp(t, t[moves], np.unwrap(np.arctan2(v[moves, 1], v[moves, 0])))
    return Trajectory(t, track.positions(t), Rotation.from_euler("z", course[:, None]).as_quat())


class Sight:
    """A camera next to the IMU, and what follows features through its images; there are none while ``dark``.

    ``late_s`` is what nothing says, ``held_s`` of a time by how much later its image comes, which its age tells.
    """

    def __init__(
        self, source: Source, track: VehicleTrack, late_s: float, dark: tuple[float, float] = (0.0, 0.0),
        held_s: Callable[[float], float] = lambda t: 0.0,
    ) -> None:  # fmt: skip
        self._source, self._late_s, self._count = source, late_s, 0
        self.tracks: FeatureTracks = simulate_tracks(driven(track), CAMERA, VIEW, 1)
        self._t, self._begin = self.tracks.frames()
        self._open = [i for i, t in enumerate(self._t) if not dark[0] <= t < dark[1]]
        self._come = np.maximum.accumulate([t + late_s + held_s(float(t)) for t in self._t])

    trouble = ""

    def follow(self, image: CameraImage) -> FeaturePositions:
        rows = slice(*self._begin[int(image.jpeg) : int(image.jpeg) + 2].tolist())
        return self.tracks.feature[rows], self.tracks.uv[rows]

    def advance(self) -> None:
        """All there is, is there."""

    @property
    def up_to_ns(self) -> int:
        return round(self._source.device.imu.time * 1e9)

    def take(self, until_ns: int) -> Sequence[CameraImage]:
        found = list[CameraImage]()
        while self._open and (read_ns := round(self._come[self._open[0]] * 1e9)) <= until_ns:
            i = self._open.pop(0)
            taken_ns, jpeg = round((self._t[i] + self._late_s) * 1e9), str(i).encode()
            found.append(CameraImage(taken_ns, None, jpeg, read_ns))
        self._count += len(found)
        return found

    def stream(self) -> StreamState:
        return StreamState("camera simulated", 10.0, 0.0, self._count, 0, 0, 0, trouble=self.trouble)
