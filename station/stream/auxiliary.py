"""Devices read alongside the IMU: receiver, camera, wheel; live and recorded.

A message that came too late for its tick is noted in `late.csv`, so that a replay counts it as the run did.
"""

import csv
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Generic, Protocol, TypeVar

from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from drivers.errors import DriverError
from station.errors import DataRefused
from station.files.atomic_file import add_rows
from station.files.mcap_files.gnss_file import Record
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import MESSAGES, RAW
from station.stream.live.live_feed import ChunkSource
from station.stream.reader import Chunk, StreamGap
from station.stream.reader.messages import LOST
from station.stream.reader.reader import FOR_EVER
from station.stream.stream_events import StreamState

LATE_MESSAGES_FILE = "late.csv"
COLUMNS = ("stream", "read_ns", "counted_ns")
LateMessages = dict[int, int]  # by the moment of reading [ns], the moment of the tick [ns] that took it


def note_late_messages(folder: Path, stream: str, read_ns: Iterable[int], counted_ns: int) -> None:
    """Add what was read at some moments [ns] and counts from a later tick on.

    Raise `CannotWrite` if the disk refuses.
    """
    add_rows(folder / LATE_MESSAGES_FILE, COLUMNS, ((stream, read, counted_ns) for read in read_ns))


def read_late_messages(folder: Path, stream: str) -> LateMessages:
    """Return the late messages of a stream in the run that a folder holds; nothing where all came in time.

    A row that a kill cut short is not used. Raise `DataRefused` if there is a table that cannot be read.
    """
    path = folder / LATE_MESSAGES_FILE
    try:
        with path.open(newline="", encoding="utf-8") as table:
            rows = [row for row in csv.reader(table) if len(row) == len(COLUMNS) and row[0] == stream]
        late = {int(read): int(counted) for _, read, counted in rows}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, csv.Error) as error:
        raise DataRefused(
            path, None, f"no readable table ({error})", f"the {LATE_MESSAGES_FILE} of a run"
        ) from error
    return {read: counted for read, counted in late.items() if counted > read}


SILENT_S = 1.8  # it is to be reported within 2 s
RATE_NS = 5 * 10**9
T = TypeVar("T", bound=Record | CameraImage | WheelReading)


def came_ns(record: Record | CameraImage | WheelReading) -> int:
    """Return the moment [ns] from which it was there, live as in a replay: it may be of long before."""
    return record.host_ns if isinstance(record, Record) else record.came_ns


class CompanionSource(ChunkSource, Protocol):
    """Where its chunks come from: a reader process."""

    @property
    def up_to_ns(self) -> int:
        """The moment up to which all that came was polled [ns]."""
        ...


class LiveCompanion(Generic[T]):
    """One device, read and decoded; call `advance` often. What is reported waits for `take`, ``most`` of it."""

    def __init__(self, source: CompanionSource, most: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._source, self._clock, self.address = source, clock, source.address
        self._waiting: deque[T] = deque(maxlen=most)
        self._bytes_at = clock()
        self._away = self._ended = ""

    def advance(self, timeout_s: float = 0.0) -> None:
        """Take what has come; what is wrong stands in `trouble`, nothing is raised but `CannotWrite`."""
        try:
            items = self._source.poll(timeout_s)
        except DriverError as error:
            self._ended = str(error)
            return
        for item in items:
            self._bytes_at = self._clock()
            if isinstance(item, StreamGap):
                self._away = "" if item.is_open else item.reason
        self._hear(items)

    def _hear(self, items: Sequence[Chunk | StreamGap]) -> None:
        raise NotImplementedError

    def stream(self) -> StreamState:
        """Return its health."""
        raise NotImplementedError

    @property
    def up_to_ns(self) -> int:
        """The moment [ns] up to which nothing more will come; for ever where the device is gone."""
        return FOR_EVER if self._away or self._ended else self._source.up_to_ns

    def take(self, until_ns: int) -> Sequence[T]:
        """Return what came since the last call and until a moment [ns], in order."""
        found = list[T]()
        while self._waiting and came_ns(self._waiting[0]) <= until_ns:
            found.append(self._waiting.popleft())
        return found

    def _gone(self, expected: str) -> str:
        """Return why no bytes come, and what to do; ``expected`` says both where they only fail to come."""
        name = self.address.name
        if self._ended:
            return self._ended
        if self._away:
            remedy = "check cable and power" if self._away.startswith(LOST) else "nothing is to be done"
            return f"{name}: {self._away}; it is tried again and again: {remedy}"
        is_silent = self._clock() - self._bytes_at >= SILENT_S
        return f"{name}: no bytes for {SILENT_S:g} s, expected {expected}" if is_silent else ""


class DecodedCompanion(LiveCompanion[T]):
    """One whose bytes are all its readings; a subclass says what is wrong with bytes that hold none, ``unread``.

    ``kind`` is what it is, ``lacks`` what comes from none and what to do; ``faults`` counts readings lost and bad.
    """

    def __init__(
        self, source: CompanionSource, most: int, clock: Callable[[], float],
        feed: Callable[[bytes, int], list[T]], *, kind: str, lacks: str, unread: str,
        faults: Callable[[], tuple[int, int]],
    ) -> None:  # fmt: skip
        super().__init__(source, most, clock)
        self._feed, self._name, self._faults = feed, f"{kind} {self.address.name}", faults
        self._lacks, self._unread = lacks, unread
        self._seen: deque[float] = deque()
        self._heard_at = clock()
        self.readings = 0

    def _hear(self, items: Sequence[Chunk | StreamGap]) -> None:
        for item in items:
            found = [] if isinstance(item, StreamGap) else self._feed(item.data, item.host_ns)
            if found or isinstance(item, StreamGap):
                self._heard_at = self._clock()
            self._seen.extend([self._heard_at] * len(found))
            self._waiting.extend(found)
            self.readings += len(found)

    @property
    def trouble(self) -> str:
        """What is wrong, and what to do; empty if nothing is."""
        if gone := self._gone(self._lacks):
            return gone
        is_unread = self._clock() - self._heard_at >= SILENT_S
        return f"{self.address.name}: {self._unread}" if is_unread else ""

    def stream(self) -> StreamState:
        """Return its health."""
        now, (lost, bad) = self._clock(), self._faults()
        while self._seen and self._seen[0] < now - RATE_NS / 1e9:
            self._seen.popleft()
        rate = len(self._seen) / (RATE_NS / 1e9)
        return StreamState(
            self._name, rate, now - self._heard_at, self.readings, 0, lost, bad, trouble=self.trouble
        )


def recorded_readings(
    folder: Path, session: str, topic: str, new_feed: Callable[[], Callable[[bytes, int], list[T]]]
) -> Iterator[T]:
    """Yield what the bytes of all sessions of that name in a folder say, in order; each is decoded by itself.

    Raise `DataRefused` if a file is damaged; one cut short is read as far as it goes.
    """
    for path in sorted(folder.glob(f"{session}_*.mcap")):
        feed = new_feed()
        for raw in topic_messages(path, {topic: MESSAGES[RAW].FromString}):
            yield from feed(raw.data, raw.host_ns)


class RecordedCompanion(Generic[T]):
    """The same of a recording, by the moments at which it was read then; no more than one record is held.

    ``counts`` selects the records that rate and age are of; ``late`` says when late ones counted.
    """

    up_to_ns = FOR_EVER

    def __init__(
        self,
        name: str,
        records: Iterator[T],
        late: LateMessages,
        counts: Callable[[T], bool] = lambda record: True,
    ) -> None:
        self._name, self._records, self._late, self._counts = name, records, late, counts
        self._next = next(records, None)
        self._samples, self._seen, self._now = 0, deque[int](), 0

    def advance(self) -> None:
        """Nothing more will come."""

    def take(self, until_ns: int) -> Sequence[T]:
        """Return what came since the last call and until a moment [ns], in order."""
        found = list[T]()
        while self._next is not None and self._counted_ns(self._next) <= until_ns:
            found.append(self._next)
            self._next = next(self._records, None)
        came = [came_ns(record) for record in found if self._counts(record)]
        self._samples, self._now = self._samples + len(came), until_ns
        self._seen.extend(came)
        while len(self._seen) > 1 and self._seen[0] <= until_ns - RATE_NS:
            self._seen.popleft()
        return found

    def _counted_ns(self, record: T) -> int:
        return self._late.get(at := came_ns(record), at)

    def stream(self) -> StreamState:
        """Return how often it came then, and how old the newest was."""
        age = (self._now - self._seen[-1]) / 1e9 if self._seen else 0.0
        rate = sum(at > self._now - RATE_NS for at in self._seen) / (RATE_NS / 1e9)
        return StreamState(f"{self._name} recorded", rate, age, self._samples, gaps=0, lost=0, bad=0)


Companion = LiveCompanion[T] | RecordedCompanion[T]
