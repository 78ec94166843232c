"""Where a camera is fixed to the IMU in its cube, carried along a vehicle's track."""

import numpy as np

from drivers.simulated.bench_in_memory import stand
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.imu import Z_UP_POSITION
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_motion import turned
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.arrays import FloatArray
from procedures.frames import rotation


class Mounted:
    """The pose of a camera at true times [s]; without a track it stands at the origin, the cube on its bottom."""

    def __init__(self, truth: Truth, camera: CameraTruth, track: VehicleTrack | None) -> None:
        world = stand(truth)
        self._camera, self._track, self._C_sb = camera, track, world.C_sb
        self._C_bn = world.attitude(Z_UP_POSITION)
        if track is not None:
            steps = int(np.ceil(track.t[-1] / truth.sample_period_s)) + 2
            self._t: FloatArray = np.float64(truth.sample_period_s) * np.arange(steps)
            self._angle = turned(self._t, track.velocities(self._t), self._C_bn)

    def pose(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return ``C_nc`` (3, 3), camera to East-North-Up, and where the camera is (3,) [m]."""
        C_bn, p = self._C_bn, np.zeros(3)
        if self._track is not None:
            C_bn = rotation(-float(np.interp(t, self._t, self._angle)) * self._C_bn[:, 2]) @ self._C_bn
            p = self._track.position(t)
        C_ns = C_bn.T @ self._C_sb.T
        return C_ns @ self._camera.C_bc, p + C_ns @ self._camera.t_bc
