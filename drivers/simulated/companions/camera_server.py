"""A simulated camera: renders what it sees when somebody reads, and serves it over HTTP as ustreamer does."""

import contextlib
import socket
from collections import deque
from collections.abc import Iterable, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from queue import Empty, Queue
from threading import Thread

import numpy as np

from drivers.camera.decoder import CONTENT_TYPE, part
from drivers.simulated.bench_in_memory import world_with_effects
from drivers.simulated.companions.camera_room import Floats, Room, pyramid
from drivers.simulated.companions.companion_device import CompanionDevice
from drivers.simulated.companions.truths import CameraTruth
from drivers.simulated.faults import TimedFault, active
from drivers.simulated.imu import Z_UP_POSITION
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack, turn_angle
from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.vision.feature_tracker import Image
from procedures.optional_libraries import opencv

DARK_GREY = 4.0  # grey of an image in the dark
NOISE_SAMPLES = 2**17  # drawn once: images differ in where they begin among it


class CameraImages:
    """A camera carried with the IMU of ``truth`` along ``track``; image ``k`` is taken at ``k / rate_hz``.

    Without a track it stands at the origin. Equal seeds give equal images. ``seed`` None: no noise.
    """

    def __init__(
        self,
        truth: Truth,
        camera: CameraTruth,
        faults: Sequence[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
    ) -> None:
        world = world_with_effects(truth)
        self.camera, self._track, self._C_sb = camera, track, world.C_sb
        self._C_bn = world.attitude(Z_UP_POSITION)
        if track is not None:
            steps = int(np.ceil(track.t[-1] / truth.sample_period_s)) + 2
            self._t: FloatArray = np.float64(truth.sample_period_s) * np.arange(steps)
            self._angle = turn_angle(self._t, track.velocities(self._t), self._C_bn)
        self._cv = opencv()
        self.faults, self.room = faults, Room(track)
        pyramid()  # made now, so that the first image is in time
        self._size = camera.height, camera.width
        rng = np.random.default_rng([seed or 0, 0xCA3E])
        noise = rng.standard_normal(NOISE_SAMPLES + camera.height * camera.width, dtype=np.float32)
        self._noise = noise * np.float32(0 if seed is None else camera.noise)

    def pose(self, t: float) -> tuple[FloatArray, FloatArray]:
        """Return ``C_nc`` (3, 3), camera to East-North-Up, and where it is (3,) [m], at true time ``t`` [s]."""
        C_bn, p = self._C_bn, np.zeros(3)
        if self._track is not None:
            C_bn = rotation(-float(np.interp(t, self._t, self._angle)) * self._C_bn[:, 2]) @ self._C_bn
            p = self._track.position(t)
        C_ns = C_bn.T @ self._C_sb.T
        return C_ns @ self.camera.C_bc, p + C_ns @ self.camera.t_bc

    def image(self, t: float) -> Image:
        """Return what is seen at true time ``t`` [s], 8 bit grey (h, w)."""
        is_dark = active(self.faults, t, "dark")
        seen = self.room.image
        grey = np.full(self._size, DARK_GREY, np.float32) if is_dark else seen(self.camera, *self.pose(t))
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


POLL_S = 0.002
PATH = "/stream"


class SimulatedCamera(CompanionDevice):
    """A camera on a TCP port of the loopback while the ``with`` block lasts.

    Parameters
    ----------
    truth, camera, faults, track, seed
        What is simulated, see `CameraImages`.
    imu
        The device whose time it shares; without it, the host's, ``speed`` times as fast.
    port
        Where it listens; 0: any free one.
    """

    def __init__(
        self,
        truth: Truth,
        camera: CameraTruth | None = None,
        faults: Iterable[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
        *,
        imu: SimulatedDevice | None = None,
        speed: float = 1.0,
        port: int = 0,
    ) -> None:
        super().__init__("simulated camera", faults, imu, speed, self._plug_in, self._pull_out)
        self.images = CameraImages(truth, camera or CameraTruth(), self.faults, track, seed)
        self.camera = self.images.camera
        self._port = port
        self._server: _Server | None = None
        self._number = 0  # of the next image
        self._waiting: deque[tuple[float, bytes]] = deque()  # until the camera is through with them

    @property
    def url(self) -> str:
        """The URL by which a station opens it."""
        return f"camera:http://127.0.0.1:{self._port}{PATH}"

    def _plug_in(self) -> None:
        self._server = _Server(self._port)
        self._port = self._server.server_address[1]

    def _pull_out(self) -> None:
        if self._server is not None:
            self._server.end()
            self._server = None

    def _step(self, now: float, *, is_plugged: bool) -> None:
        """Take the image that is due, and show those whose latency is over."""
        server, rate = self._server, self.camera.rate_hz
        taken = self._number / rate
        if self._waiting and self._waiting[0][0] <= now:  # first: who renders slowly is always due to take one
            _, sent = self._waiting.popleft()
            if server is not None:
                server.show(sent)
        elif now >= taken:
            if server is not None and server.lookers and not active(self.faults, taken, "stall"):
                self._waiting.append((taken + self.camera.latency_s, self.images.part(taken)))
            self._number = max(self._number + 1, int(now * rate))  # images whose time is over are left out
        else:
            self._stop.wait(POLL_S)


class _Server(ThreadingHTTPServer):
    """Shows whoever looks the newest part."""

    def __init__(self, port: int) -> None:
        super().__init__(("127.0.0.1", port), _Looker)
        self.is_over = False
        self.lookers: dict[socket.socket, Queue[bytes]] = {}  # what each is to be shown next; empty at the end
        self._thread = Thread(target=self.serve_forever, args=(0.02,), name="simulated camera's port", daemon=True)
        self._thread.start()

    def show(self, sent: bytes) -> None:
        for shown in list(self.lookers.values()):
            with contextlib.suppress(Empty):  # who is too slow misses it
                shown.get_nowait()
            shown.put(sent)

    def end(self) -> None:
        """Hang up and listen no more."""
        self.shutdown()
        self.is_over = True
        for caller in list(self.lookers):
            with contextlib.suppress(OSError):
                caller.shutdown(socket.SHUT_RDWR)
        self.show(b"")
        self.server_close()
        self._thread.join()


class _Looker(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        if self.path.partition("?")[0] != PATH:
            self.send_error(404)
            return
        shown = self.server.lookers[self.connection] = Queue[bytes]()
        try:
            self.send_response(200)
            self.send_header("Content-Type", CONTENT_TYPE)
            self.end_headers()
            while not self.server.is_over and (sent := shown.get()):
                self.wfile.write(sent)
        except OSError:
            pass
        finally:
            del self.server.lookers[self.connection]

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""
