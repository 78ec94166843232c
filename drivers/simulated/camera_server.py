"""Serves a simulated camera over HTTP as ustreamer does, beside a simulated IMU or alone.

An image is rendered when its time has come and somebody looks; who reads too slowly misses images.
"""

import contextlib
import socket
import time
from collections.abc import Iterable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Condition, Event, Thread
from types import TracebackType
from typing import Self

from drivers.camera.parts import CONTENT_TYPE
from drivers.simulated.camera_faults import CameraFault
from drivers.simulated.camera_images import CameraImages
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.pace import TrueTime
from drivers.simulated.timed_faults import active
from drivers.simulated.track import Track
from drivers.simulated.truth import Truth

POLL_S = 0.002
PATH = "/stream"


class SimulatedCamera:
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
        faults: Iterable[CameraFault] = (),
        track: Track | None = None,
        seed: int | None = 1,
        *,
        beside: TrueTime | None = None,
        speed: float = 1.0,
        port: int = 0,
    ) -> None:
        self.images = CameraImages(truth, camera or CameraTruth(), faults, track, seed)
        self.camera = self.images.camera
        self._beside, self._speed, self._port = beside, speed, port
        self._server: _Server | None = None
        self._stop = Event()
        self._thread = Thread(target=self._run, name="simulated camera", daemon=True)
        self._began = 0.0
        self.sent = 0
        self.failure: Exception | None = None

    @property
    def url(self) -> str:
        """The URL by which a station opens it."""
        return f"camera:http://127.0.0.1:{self._port}{PATH}"

    @property
    def now(self) -> float:
        """True time [s]."""
        return self._beside.true_time if self._beside else (time.monotonic() - self._began) * self._speed

    def plant(self, kind: str, seconds: float) -> None:
        """Have a fault act from now on, see `drivers.simulated.camera_faults.KINDS`."""
        self.images.faults = (*self.images.faults, CameraFault(kind, self.now, seconds))

    def __enter__(self) -> Self:
        self._plug()
        self._began = time.monotonic()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        self._unplug()

    def _plug(self) -> None:
        self._server = _Server(self._port)
        self._port = self._server.server_address[1]

    def _unplug(self) -> None:
        if self._server is not None:
            self._server.end()
            self._server = None

    def _run(self) -> None:
        try:
            number = 0
            while not self._stop.is_set():
                now = self.now
                self._look_after_the_port(now)
                taken = number / self.camera.rate_hz
                if now < taken + self.camera.latency_s:
                    self._stop.wait(POLL_S)
                    continue
                if self._server is not None and self._server.lookers and not active(self._faults, taken, "stall"):
                    self._server.show(self.images.part(taken))
                    self.sent += 1
                late = now - self.camera.latency_s  # images whose time is over are left out
                number = max(number + 1, int(late * self.camera.rate_hz))
        except Exception as error:  # the edge of a thread: kept for whoever asks, and the line goes silent
            self.failure = error

    @property
    def _faults(self) -> tuple[CameraFault, ...]:
        return self.images.faults

    def _look_after_the_port(self, now: float) -> None:
        wanted = not active(self._faults, now, "unplug")
        if wanted and self._server is None:
            self._plug()
        elif not wanted:
            self._unplug()


class _Server(ThreadingHTTPServer):
    """Shows whoever looks the newest part."""

    def __init__(self, port: int) -> None:
        super().__init__(("127.0.0.1", port), _Looker)
        self.lookers = 0
        self._changed = Condition()
        self._newest, self._number = b"", 0
        self._over = False
        self._callers: list[socket.socket] = []
        self._thread = Thread(target=self.serve_forever, args=(0.02,), name="simulated camera's port", daemon=True)
        self._thread.start()

    def show(self, sent: bytes) -> None:
        with self._changed:
            self._newest, self._number = sent, self._number + 1
            self._changed.notify_all()

    def shown(self, caller: socket.socket) -> Iterator[bytes]:
        """Yield each part that is shown from now on, the newest one where it took longer."""
        with self._changed:
            seen = self._number
            self.lookers += 1
            self._callers.append(caller)
        try:
            while True:
                with self._changed:
                    self._changed.wait_for(lambda: self._over or self._number > seen)  # noqa: B023
                    if self._over:
                        return
                    seen, newest = self._number, self._newest
                yield newest
        finally:
            with self._changed:
                self.lookers -= 1
                self._callers.remove(caller)

    def end(self) -> None:
        """Hang up and listen no more."""
        self.shutdown()
        with self._changed:
            self._over = True
            for caller in self._callers:
                with contextlib.suppress(OSError):
                    caller.shutdown(socket.SHUT_RDWR)
            self._changed.notify_all()
        self.server_close()
        self._thread.join()


class _Looker(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        if self.path.partition("?")[0] != PATH:
            self.send_error(404)
            return
        with contextlib.suppress(OSError):
            self.send_response(200)
            self.send_header("Content-Type", CONTENT_TYPE)
            self.end_headers()
            for each in self.server.shown(self.connection):
                self.wfile.write(each)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""
