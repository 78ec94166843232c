"""A camera beside the IMU: its images as they come, and what is wrong with it; and the images of a recording."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from drivers.camera import CameraDecoder, CameraImage
from station.files.atomic_file import replace_file
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC, MESSAGES, RAW
from station.stream.beside import SILENT_S, LiveCompanion
from station.stream.camera.description import CAMERA_FILE, CameraDescription
from station.stream.reader import Chunk, GapMark
from station.stream.reader.restarting_reader import RestartingReader
from station.stream.stream_events import StreamState
from station.text.plural import plural

CAMERA_SESSION = "camera_session"
RATE_WINDOW_S = 5.0
MAX_WAITING_IMAGES = 300  # images that are not taken


class CameraFeed(LiveCompanion[CameraImage]):
    """One camera, read and decoded; call `advance` often."""

    def __init__(self, reader: RestartingReader, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__(reader, MAX_WAITING_IMAGES, clock)
        self.decoder = CameraDecoder()
        self._seen: deque[float] = deque()
        self._image_at = clock()

    def _hear(self, items: Sequence[Chunk | GapMark]) -> None:
        for item in items:
            if isinstance(item, GapMark):
                self._image_at = self._clock()
                continue
            for image in self.decoder.feed(item.data, item.host_ns):
                self._image_at = self._clock()
                self._seen.append(self._image_at)
                self._waiting.append(image)

    @property
    def trouble(self) -> str:
        """What is wrong, and what to do; empty if nothing is."""
        if gone := self._gone("images; check the camera"):
            return gone
        if self._clock() - self._image_at < SILENT_S:
            return ""
        wrong = "bytes hold no whole image, expected JPEG; check the camera's format and the link"
        return f"{self.address.name}: {wrong}"

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


def recorded_images(folder: Path) -> Iterator[CameraImage]:
    """Yield the images of all sessions in a folder, in order.

    Raises
    ------
    DataRefused
        If a file is damaged; one cut short is read as far as it goes.
    """
    for path in sorted(folder.glob(f"{CAMERA_SESSION}_*.mcap")):
        decoder = CameraDecoder()
        for raw in topic_messages(path, {CAMERA_RAW_TOPIC: MESSAGES[RAW].FromString}):
            yield from decoder.feed(raw.data, raw.host_ns)
