"""The camera of a recording that is replayed: its bytes stand beside the IMU's and come as they were read."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from mcap.records import Channel, Message

from drivers.camera import CameraDecoder, CameraImage
from station.camera.feed import SESSION
from station.errors import DataRefused
from station.mcap_files.reader import DAMAGE
from station.mcap_files.records import CutShort, file_records
from station.mcap_files.schemas import CAMERA_RAW_TOPIC, MESSAGES, RAW
from station.monitor.view import Stream
from station.reader.lasting import FOR_EVER

RATE_NS = 5 * 10**9


class RecordedCamera:
    """`station.monitor.options.Seeing` of a folder's images, of which no more than one is held."""

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

    def stream(self) -> Stream:
        """Return how often images came then, and how old the newest was."""
        age = (self._now - self._seen[-1]) / 1e9 if self._seen else 0.0
        rate = len(self._seen) / (RATE_NS / 1e9)
        return Stream("camera recorded", rate, age, self._count, gaps=0, lost=0, bad=0)


def recorded_images(folder: Path) -> Iterator[CameraImage]:
    """Yield the images of all sessions in a folder, in order.

    Raises
    ------
    DataRefused
        If a file is damaged; one cut short is read as far as it goes.
    """
    for path in sorted(folder.glob(f"{SESSION}_*.mcap")):
        decoder = CameraDecoder()
        for host_ns, data in _chunks(path):
            yield from decoder.feed(data, host_ns)


def _chunks(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield what was read, and when [ns]."""
    topics, count = dict[int, str](), 0
    try:
        with path.open("rb") as stream:
            for record in file_records(stream):
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and topics[record.channel_id] == CAMERA_RAW_TOPIC:
                    raw, count = MESSAGES[RAW].FromString(record.data), count + 1
                    yield raw.host_ns, raw.data
    except CutShort:
        pass
    except DAMAGE as error:
        what = " ".join(str(error).split())[:120] or type(error).__name__
        raise DataRefused(path, None, f"damage after record {count} ({what})", "an intact file") from error
