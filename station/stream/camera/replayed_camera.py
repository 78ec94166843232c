"""The camera of a recording that is replayed: its bytes stand beside the IMU's and come as they were read."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from drivers.camera import CameraDecoder, CameraImage
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC, MESSAGES, RAW
from station.files.mcap_files.topics import topic_messages
from station.stream.camera.camera_feed import CAMERA_SESSION
from station.stream.reader.restarting_reader import FOR_EVER
from station.stream.stream_events import StreamState

RATE_NS = 5 * 10**9


class RecordedCamera:
    """`station.monitor.options.CameraSource` of a folder's images, of which no more than one is held."""

    up_to_ns = FOR_EVER

    def __init__(self, folder: Path) -> None:
        self._images = recorded_images(folder)
        self._next = next(self._images, None)
        self._count, self._seen, self._now = 0, list[int](), 0

    def advance(self) -> None:
        """Nothing more will come."""

    def take(self, until_ns: int) -> Sequence[CameraImage]:
        """Return what came since the last call and until a moment [ns], in order."""
        found = list[CameraImage]()
        while self._next is not None and self._next.host_ns <= until_ns:
            found.append(self._next)
            self._next = next(self._images, None)
        self._now, self._count = until_ns, self._count + len(found)
        self._seen = [at for at in (*self._seen, *(each.host_ns for each in found)) if at > until_ns - RATE_NS]
        return found

    def stream(self) -> StreamState:
        """Return how often images came then, and how old the newest was."""
        age = (self._now - self._seen[-1]) / 1e9 if self._seen else 0.0
        rate = len(self._seen) / (RATE_NS / 1e9)
        return StreamState("camera recorded", rate, age, self._count, gaps=0, lost=0, bad=0)


def recorded_images(folder: Path) -> Iterator[CameraImage]:
    """Yield the images of all sessions in a folder, in order.

    Raises
    ------
    DataRefused
        If a file is damaged; one cut short is read as far as it goes.
    """
    for path in sorted(folder.glob(f"{CAMERA_SESSION}_*.mcap")):
        decoder = CameraDecoder()
        for host_ns, data in topic_messages(path, {CAMERA_RAW_TOPIC: _chunk}):
            yield from decoder.feed(data, host_ns)


def _chunk(data: bytes) -> tuple[int, bytes]:
    """Return when [ns] bytes were read, and them."""
    raw = MESSAGES[RAW].FromString(data)
    return raw.host_ns, raw.data
