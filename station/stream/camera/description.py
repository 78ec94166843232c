"""A camera's file, `camera/1`: where it is, its lens, and where it sits on the IMU."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from drivers.address_parsing import parse_device_url
from drivers.addresses import CameraAddress, HttpCameraAddress, VideoDeviceAddress
from drivers.errors import BadDeviceUrl
from station.errors import DataRefused
from station.files.fusion_folder.fusion_schema import LensTable
from station.files.toml_reading import line_of, read_tables, read_text_file

CAMERA_FILE = "camera.toml"  # in a folder that is recorded


class CameraTable(LensTable):
    """All of it; what the stamps are off by is found where nothing is told of it."""

    format: Literal["camera/1"]
    url: str


@dataclass(frozen=True, slots=True, eq=False)
class CameraDescription:
    """A camera's file as it was read: ``content`` is what a recording keeps of it."""

    content: bytes
    table: CameraTable
    address: CameraAddress


def read_description(path: Path) -> CameraDescription:
    """Read a camera's file.

    Raises
    ------
    DataRefused
        If there is none, a key is missing, unknown or out of range, or its address is none of a camera.
    """
    content = read_text_file(path)
    table, lines = read_tables(content, path, CameraTable)
    try:
        address = parse_device_url(table.url, "camera")
    except BadDeviceUrl as error:
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), error.expected) from error
    if not isinstance(address, HttpCameraAddress | VideoDeviceAddress):
        expected = "camera:http://HOST:PORT/PATH or camera:/dev/videoN"
        raise DataRefused(path, line_of(("url",), lines), repr(table.url), expected)
    return CameraDescription(content, table, address)
