"""A wheel on CAN beside the IMU: its speeds as they come, and what is wrong; and the speeds of a recording."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from drivers.can.wheel_reading import WheelReading
from drivers.can.wheel_signal import WheelDecoder
from station.files.atomic_file import replace_file
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import MESSAGES, RAW, WHEEL_RAW_TOPIC
from station.stream.beside import SILENT_S, LiveCompanion
from station.stream.reader import Chunk, GapMark
from station.stream.reader.restarting_reader import RestartingReader
from station.stream.stream_events import StreamState
from station.stream.wheel.description import DBC_FILE, WHEEL_FILE, WheelDescription
from station.text.plural import plural

WHEEL_SESSION = "wheel_session"
RATE_WINDOW_S = 5.0
MAX_WAITING_READINGS = 20_000


class WheelFeed(LiveCompanion[WheelReading]):
    """One wheel, read and decoded; call `advance` often."""

    def __init__(
        self, reader: RestartingReader, described: WheelDescription, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(reader, MAX_WAITING_READINGS, clock)
        self.decoder, self._name = WheelDecoder(described.signal), described.table.signal
        self._seen: deque[float] = deque()
        self._told_at = clock()
        self.readings = 0

    def _hear(self, items: Sequence[Chunk | GapMark]) -> None:
        for item in items:
            if isinstance(item, GapMark):
                self._told_at = self._clock()
                continue
            for reading in self.decoder.feed(item.data, item.host_ns):
                self._told_at = self._clock()
                self._seen.append(self._told_at)
                self._waiting.append(reading)
                self.readings += 1

    @property
    def trouble(self) -> str:
        """What is wrong, and what to do; empty if nothing is."""
        if gone := self._gone("CAN frames; check bit rate, cable and ignition"):
            return gone
        if self._clock() - self._told_at < SILENT_S:
            return ""
        wrong = f"frames contain no {self._name}, expected a speed; check dbc and signal, or its sensor"
        return f"{self.address.name}: {wrong}"

    @property
    def summary(self) -> str:
        """What came, in a line."""
        of = self.decoder
        return (
            f"wheel {self.address.name}: {plural(self.readings, 'speed')} by {self._name}, "
            f"{of.refused} without a value, {of.bad} damaged"
        )

    def stream(self) -> StreamState:
        """Return its health."""
        now = self._clock()
        while self._seen and self._seen[0] < now - RATE_WINDOW_S:
            self._seen.popleft()
        return StreamState(
            name=f"wheel {self.address.name}", rate_hz=len(self._seen) / RATE_WINDOW_S,
            age_s=now - self._told_at, samples=self.readings, gaps=0, lost=self.decoder.refused,
            bad=self.decoder.bad, trouble=self.trouble,
        )  # fmt: skip


@contextmanager
def open_wheel(
    described: WheelDescription, folder: Path, clock: Callable[[], float] = time.monotonic
) -> Iterator[WheelFeed]:
    """Read a wheel by a process of its own while the ``with`` lasts; its files go to ``folder``.

    ``wheel_session_*.mcap`` has every frame of its bus (topic ``/wheel/raw``), ``wheel.toml`` and ``wheel.dbc``
    are the wheel's file and its DBC.

    Raises
    ------
    DriverError, CannotWrite
        What address, port or disk refuse.
    """
    replace_file(folder / WHEEL_FILE, described.content)
    replace_file(folder / DBC_FILE, described.dbc)
    with RestartingReader(described.address.text, folder, WHEEL_SESSION) as reader:
        yield WheelFeed(reader, described, clock)


def recorded_wheel(folder: Path, described: WheelDescription) -> Iterator[WheelReading]:
    """Yield the readings of all sessions in a folder, in order.

    Raises
    ------
    DataRefused
        If a file is damaged; one cut short is read as far as it goes.
    """
    for path in sorted(folder.glob(f"{WHEEL_SESSION}_*.mcap")):
        decoder = WheelDecoder(described.signal)
        for raw in topic_messages(path, {WHEEL_RAW_TOPIC: MESSAGES[RAW].FromString}):
            yield from decoder.feed(raw.data, raw.host_ns)
