"""A vehicle's wheel on CAN alongside the IMU: its file `wheel/1`, its speeds, live and recorded.

`wheel/1` says which bus it is on, which signal holds its speed, and how it is mounted relative to the IMU.
"""

import time
from collections.abc import Callable, Iterable, Iterator
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
from station.files.mcap_files.schemas import WHEEL_RAW_TOPIC
from station.files.toml_file import line_of, read_tables, read_text_file
from station.stream.auxiliary import DecodedCompanion, recorded_readings
from station.stream.gnss_fix_times import FixTimes
from station.stream.reader.reader import RestartingReader
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
MAX_WAITING_READINGS = 20_000


class WheelFeed(DecodedCompanion[WheelReading]):
    """One wheel, read and decoded; call `advance` often."""

    def __init__(
        self, reader: RestartingReader, described: WheelDescription, clock: Callable[[], float] = time.monotonic
    ) -> None:
        of, self._signal = WheelDecoder(described.signal), described.table.signal
        self.decoder = of
        super().__init__(
            reader, MAX_WAITING_READINGS, clock, of.feed, kind="wheel", faults=lambda: (of.refused, of.bad),
            lacks="CAN frames; check bit rate, cable and ignition",
            unread=f"frames contain no {self._signal}, expected a speed; check dbc and signal, or its sensor",
        )  # fmt: skip

    @property
    def summary(self) -> str:
        """What came, in a line."""
        of = self.decoder
        return (
            f"wheel {self.address.name}: {plural(self.readings, 'speed')} by {self._signal}, "
            f"{of.refused} without a value, {of.bad} damaged"
        )


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
    """Yield the readings of all sessions in a folder; raises as `recorded_readings`."""
    return recorded_readings(folder, WHEEL_SESSION, WHEEL_RAW_TOPIC, lambda: WheelDecoder(described.signal).feed)


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
