"""What a simulated camera sends: images of the room at their times, as parts of a multipart stream."""

from collections.abc import Sequence

import numpy as np

from drivers.camera.decoder import part
from drivers.simulated.bench_in_memory import world_with_effects
from drivers.simulated.camera_room import Room
from drivers.simulated.camera_texture import Floats, pyramid
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.imu import Z_UP_POSITION
from drivers.simulated.timed_faults import TimedFault, active
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack, turn_angle
from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.vision.feature_tracker import Image
from procedures.optional_libraries import opencv

DARK_GREY = 4.0  # grey of an image in the dark
NOISE_SAMPLES = 2**17  # drawn once: images differ in where they begin among it


class CameraMount:
    """The pose of a camera at true times [s]; without a track it stands at the origin, the cube on its bottom."""

    def __init__(self, truth: Truth, camera: CameraTruth, track: VehicleTrack | None) -> None:
        world = world_with_effects(truth)
        self.camera, self._track, self._C_sb = camera, track, world.C_sb
        self._C_bn = world.attitude(Z_UP_POSITION)
        if track is not None:
            steps = int(np.ceil(track.t[-1] / truth.sample_period_s)) + 2
            self._t: FloatArray = np.float64(truth.sample_period_s) * np.arange(steps)
            self._angle = turn_angle(self._t, track.velocities(self._t), self._C_bn)

    def pose(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return ``C_nc`` (3, 3), camera to East-North-Up, and where the camera is (3,) [m]."""
        C_bn, p = self._C_bn, np.zeros(3)
        if self._track is not None:
            C_bn = rotation(-float(np.interp(t, self._t, self._angle)) * self._C_bn[:, 2]) @ self._C_bn
            p = self._track.position(t)
        C_ns = C_bn.T @ self._C_sb.T
        return C_ns @ self.camera.C_bc, p + C_ns @ self.camera.t_bc


class CameraImages(CameraMount):
    """A camera carried with the IMU of ``truth`` along ``track``; image ``k`` is taken at ``k / rate_hz``.

    Equal seeds give equal images. ``seed`` None: no noise.
    """

    def __init__(
        self,
        truth: Truth,
        camera: CameraTruth,
        faults: Sequence[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
    ) -> None:
        super().__init__(truth, camera, track)
        self._cv = opencv()
        self.faults, self.room = faults, Room(track)
        pyramid()  # made now, so that the first image is in time
        self._size = camera.height, camera.width
        rng = np.random.default_rng([seed or 0, 0xCA3E])
        noise = rng.standard_normal(NOISE_SAMPLES + camera.height * camera.width, dtype=np.float32)
        self._noise = noise * np.float32(0 if seed is None else camera.noise)

    def image(self, t: float) -> Image:
        """Return what is seen at true time ``t`` [s], 8 bit grey (h, w)."""
        is_dark = active(self.faults, t, "dark")
        grey = (
            np.full(self._size, DARK_GREY, np.float32) if is_dark else self.room.image(self.camera, *self.pose(t))
        )
        image: Image = np.clip(np.rint(grey + self._drawn(t)), 0, 255).astype(np.uint8)
        return image

    def jpeg(self, t: float) -> bytes:
        """Return the image at true time ``t`` [s], compressed."""
        options = [self._cv.IMWRITE_JPEG_QUALITY, self.camera.quality]
        _, encoded = self._cv.imencode(".jpg", self.image(t), options)
        return bytes(encoded)

    def part(self, t: float) -> bytes:
        """Return the image at true time ``t`` [s] as it is sent."""
        sent = part(self.jpeg(t), None if active(self.faults, t, "no_stamp") else self.camera.stamp(t))
        return sent[: len(sent) // 2] if active(self.faults, t, "cut") else sent

    def _drawn(self, t: float) -> Floats:
        begin = int(np.random.default_rng(round(t * 1e6)).integers(NOISE_SAMPLES))
        return self._noise[begin:][: self._size[0] * self._size[1]].reshape(self._size)
