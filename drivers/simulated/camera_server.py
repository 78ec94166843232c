"""Serves a simulated camera over HTTP as ustreamer does, beside a simulated IMU or alone.

An image is rendered when its time has come and somebody looks; who reads too slowly misses images.
"""

import contextlib
import socket
from collections import deque
from collections.abc import Iterable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from queue import Empty, Queue
from threading import Thread

from drivers.camera.decoder import CONTENT_TYPE
from drivers.simulated.camera_images import CameraImages
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.companion_devices import CompanionDevice
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.timed_faults import TimedFault, active
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack

POLL_S = 0.002
PATH = "/stream"


class SimulatedCamera(CompanionDevice):
    """A camera on a TCP port of the loopback while the ``with`` block lasts.

    Parameters
    ----------
    truth, camera, faults, track, seed
        What is simulated, see `CameraImages`.
    beside
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
        beside: SimulatedDevice | None = None,
        speed: float = 1.0,
        port: int = 0,
    ) -> None:
        super().__init__("simulated camera", faults, beside, speed)
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

    def _plug(self) -> None:
        self._server = _Server(self._port)
        self._port = self._server.server_address[1]

    def _unplug(self) -> None:
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
