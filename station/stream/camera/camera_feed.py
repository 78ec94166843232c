"""A live camera beside the IMU: its images as they come, and what is wrong with it."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from drivers.camera import CameraDecoder, CameraImage
from drivers.errors import DriverError
from station.files.atomic_file import replace_file
from station.stream.camera.description import CAMERA_FILE, CameraDescription
from station.stream.reader import GapMark
from station.stream.reader.messages import LOST
from station.stream.reader.restarting_reader import FOR_EVER, RestartingReader
from station.stream.stream_events import StreamState
from station.text.plural import plural

CAMERA_SESSION = "camera_session"
RATE_WINDOW_S = 5.0
SILENT_S = 1.8  # it is to be said within 2 s
MAX_WAITING_IMAGES = 300  # images that are not taken


class CameraFeed:
    """One camera, read and decoded; call `advance` often. `station.monitor.options.CameraSource`."""

    def __init__(self, reader: RestartingReader, clock: Callable[[], float] = time.monotonic) -> None:
        self._reader, self._clock, self.address = reader, clock, reader.address
        self.decoder = CameraDecoder()
        self._images: deque[CameraImage] = deque(maxlen=MAX_WAITING_IMAGES)
        self._seen: deque[float] = deque()
        self._bytes_at = self._image_at = clock()
        self._away = self._ended = ""

    def advance(self) -> None:
        """Take what has come; a camera that is gone stands in `trouble`, nothing is raised but `CannotWrite`."""
        try:
            items = self._reader.poll(0.0)
        except DriverError as error:
            self._ended = str(error)
            return
        for item in items:
            if isinstance(item, GapMark):
                self._away = "" if item.is_open else item.reason
                self._bytes_at = self._image_at = self._clock()
            else:
                self._bytes_at = self._clock()
                self._take(self.decoder.feed(item.data, item.host_ns))

    @property
    def up_to_ns(self) -> int:
        """The moment [ns] up to which nothing more will come; for ever where the camera is gone."""
        return FOR_EVER if self._away or self._ended else self._reader.up_to_ns

    def take(self, until_ns: int) -> Sequence[CameraImage]:
        """Return the images that came since the last call and until a moment [ns], in order."""
        found = list[CameraImage]()
        while self._images and self._images[0].host_ns <= until_ns:
            found.append(self._images.popleft())
        return found

    @property
    def trouble(self) -> str:
        """What is wrong, and what to do; empty if nothing is."""
        name, now = self.address.name, self._clock()
        if self._ended:
            return self._ended
        if self._away:
            remedy = "check cable and power" if self._away.startswith(LOST) else "nothing is to be done"
            return f"{name}: {self._away}; it is tried again and again: {remedy}"
        if now - self._bytes_at >= SILENT_S:
            return f"{name}: no bytes for {SILENT_S:g} s, expected images; check the camera"
        if now - self._image_at >= SILENT_S:
            return f"{name}: bytes hold no whole image, expected JPEG; check the camera's format and the link"
        return ""

    @property
    def summary(self) -> str:
        """What came, in a line."""
        counters = self.decoder.counters
        return (
            f"camera {self.address.name}: {plural(counters.images, 'image')}, {counters.cut} cut, "
            f"{counters.not_jpeg} no JPEG, {plural(counters.skipped_bytes, 'byte')} in no image"
        )

    def stream(self) -> StreamState:
        """Return its health."""
        now, counters = self._clock(), self.decoder.counters
        while self._seen and self._seen[0] < now - RATE_WINDOW_S:
            self._seen.popleft()
        return StreamState(
            name=f"camera {self.address.name}", rate_hz=len(self._seen) / RATE_WINDOW_S,
            age_s=now - self._image_at, samples=counters.images, gaps=0, lost=counters.cut, bad=counters.not_jpeg,
            trouble=self.trouble,
        )  # fmt: skip

    def _take(self, images: Sequence[CameraImage]) -> None:
        for image in images:
            self._image_at = self._clock()
            self._seen.append(self._image_at)
            self._images.append(image)


@contextmanager
def open_camera(
    described: CameraDescription, folder: Path, clock: Callable[[], float] = time.monotonic
) -> Iterator[CameraFeed]:
    """Read a camera by a process of its own while the ``with`` lasts; its files go to ``folder``.

    ``camera_session_*.mcap`` has every byte (topic ``/camera/raw``), ``camera.toml`` is the camera's file.

    Raises
    ------
    DriverError, CannotWrite
        What address, port or disk refuse.
    """
    replace_file(folder / CAMERA_FILE, described.content)
    with RestartingReader(described.address.text, folder, CAMERA_SESSION) as reader:
        yield CameraFeed(reader, clock)
