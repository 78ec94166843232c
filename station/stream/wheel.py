"""A vehicle's wheel on CAN alongside the IMU: its file `wheel/1`, its speeds, live and recorded.

`wheel/1` says which bus it is on, which signal holds its speed, and how it is mounted relative to the IMU.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlencode

import numpy as np
from pydantic import Field

from drivers.address_parsing import parse_device_url
from drivers.addresses import WheelAddress
from drivers.can.frame_record import WheelReading
from drivers.can.wheel_signal import WheelDecoder, WheelSignal, wheel_signal
from drivers.errors import BadDeviceUrl
from procedures.fusion.fusion_records import WheelSpeeds
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_schema import WheelMountTable
from station.files.mcap_files.reader import topic_messages
from station.files.mcap_files.schemas import MESSAGES, RAW, WHEEL_RAW_TOPIC
from station.files.toml_file import line_of, read_tables, read_text_file
from station.stream.auxiliary import SILENT_S, LiveCompanion
from station.stream.gnss_fix_times import FixTimes
from station.stream.reader import Chunk, StreamGap
from station.stream.reader.reader import RestartingReader
from station.stream.stream_events import StreamState
from station.text import plural

WHEEL_FILE, DBC_FILE = "wheel.toml", "wheel.dbc"  # in a folder that is recorded


class WheelDescriptionTable(WheelMountTable):
    """All of it. ``time_offset_s`` is added to the moments at which frames are read: minus what they are late."""

    format: Literal["wheel/1"]
    url: str
    dbc: str
    signal: str
    unit: str = ""
    time_offset_s: Annotated[float, Field(ge=-1, le=1)] = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class WheelDescription:
    """A wheel's file as it was read: ``content`` and ``dbc`` are what a recording keeps of it and of its DBC."""

    content: bytes
    dbc: bytes
    table: WheelDescriptionTable
    address: WheelAddress
    signal: WheelSignal


def read_description(path: Path, kept: Path | None = None) -> WheelDescription:
    """Read a wheel's file and its DBC, which lies next to it or is named by its whole path; or as it was ``kept``.

    Raises
    ------
    DataRefused
        If there is none, a key is missing, unknown or out of range, or its address is none of a CAN bus.
    BadCanFile
        If the DBC is none or has no such signal, or its unit is no speed.
    """
    content = read_text_file(path)
    table, lines = read_tables(content, path, WheelDescriptionTable)
    dbc = kept or path.parent / table.dbc
    signal = wheel_signal(str(dbc), table.signal, table.unit)
    reported = {"dbc": str(dbc.absolute()), "signal": table.signal, "unit": table.unit}
    more = urlencode({name: value for name, value in reported.items() if value})
    try:
        address = parse_device_url(f"wheel:{table.url}{'&' if '?' in table.url else '?'}{more}")
    except BadDeviceUrl as error:
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), error.expected) from error
    assert isinstance(address, WheelAddress)  # the scheme given above
    return WheelDescription(content, dbc.read_bytes(), table, address, signal)


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
        self._heard_at = clock()
        self.readings = 0

    def _hear(self, items: Sequence[Chunk | StreamGap]) -> None:
        for item in items:
            if isinstance(item, StreamGap):
                self._heard_at = self._clock()
                continue
            for reading in self.decoder.feed(item.data, item.host_ns):
                self._heard_at = self._clock()
                self._seen.append(self._heard_at)
                self._waiting.append(reading)
                self.readings += 1

    @property
    def trouble(self) -> str:
        """What is wrong, and what to do; empty if nothing is."""
        if gone := self._gone("CAN frames; check bit rate, cable and ignition"):
            return gone
        if self._clock() - self._heard_at < SILENT_S:
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
            age_s=now - self._heard_at, samples=self.readings, gaps=0, lost=self.decoder.refused,
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


def described_in(folder: Path) -> WheelDescription | None:
    """Return the wheel with a recording, by the DBC that was kept there; None where there was none."""
    if not (folder / WHEEL_FILE).exists():
        return None
    return read_description(folder / WHEEL_FILE, folder / DBC_FILE)


def recorded_speeds(
    folder: Path, marks: Iterable[tuple[int, float]]
) -> tuple[WheelSpeeds, WheelMountTable] | None:
    """Return what the wheel with a recording reported, and how it stands to the IMU; None where there was none.

    ``marks`` are moments of reading [ns] and the device times [s] of the samples that came then.

    Raises
    ------
    DataRefused, BadCanFile
        If the wheel's file, its DBC or its bytes are damaged.
    """
    if (described := described_in(folder)) is None:
        return None
    times = FixTimes()
    for host_ns, device_s in marks:
        times.stamp_imu(host_ns, device_s)
    reported = [(times.of(each), each.speed) for each in recorded_wheel(folder, described)]
    rows = np.array([(t, speed) for t, speed in reported if t is not None]).reshape(-1, 2)
    rows[:, 0] += described.table.time_offset_s
    rows = rows[np.r_[True, np.diff(np.maximum.accumulate(rows[:, 0])) > 0]] if len(rows) else rows
    return WheelSpeeds(rows[:, 0], rows[:, 1]), described.table
