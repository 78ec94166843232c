"""A wheel's file, `wheel/1`: the bus it is on, the signal that tells its speed, and how it stands to the IMU."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal
from urllib.parse import urlencode

from pydantic import Field

from drivers.address_parsing import parse_device_url
from drivers.addresses import WheelAddress
from drivers.can.wheel_signal import WheelSignal, wheel_signal
from drivers.errors import BadDeviceUrl
from station.errors import DataRefused
from station.files.fusion_folder.fusion_schema import WheelMountTable
from station.files.toml_reading import line_of, read_tables, read_text_file

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
    """Read a wheel's file and its DBC, which lies beside it or is named by its whole path; or as it was ``kept``.

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
    told = {"dbc": str(dbc.absolute()), "signal": table.signal, "unit": table.unit}
    more = urlencode({name: value for name, value in told.items() if value})
    try:
        address = parse_device_url(f"wheel:{table.url}{'&' if '?' in table.url else '?'}{more}")
    except BadDeviceUrl as error:
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), error.expected) from error
    assert isinstance(address, WheelAddress)  # the scheme given above
    return WheelDescription(content, dbc.read_bytes(), table, address, signal)
