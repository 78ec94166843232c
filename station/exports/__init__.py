"""A calibration in the words of those who apply it; a line here puts a receiver on the list.

A receiver's file makes texts of a `Correction`, offset and scale about a driver's nominal scale factor, or of the
whole `StoredCalibration`. What it cannot carry it says in comments.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from station.exports import ardupilot, c99, imu_calib, kalibr, matlab, px4
from station.exports.correction import Correction, NominalScale, read_correction
from station.exports.stored_calibration import read_stored

PREFIX = "fog_imu"  # of the names in a program


@dataclass(frozen=True, slots=True)
class Request:
    """What is asked for: a calibration/1, a driver's scale factors if known, and how a program is made."""

    path: Path
    accel: float | None = None
    gyro: float | None = None
    prefix: str = PREFIX
    is_float: bool = False


@dataclass(frozen=True, slots=True)
class Export:
    """A receiver: its name on the command line, who it is, and its files by the end of their names."""

    name: str
    title: str
    ends: tuple[str, ...]
    files: Callable[[Request], Mapping[str, bytes]]


def _corrected(end: str, text: Callable[[Correction], str]) -> Callable[[Request], Mapping[str, bytes]]:
    return lambda asked: {end: text(read_correction(asked.path, asked.accel, asked.gyro)).encode()}


def _c99(asked: Request) -> Mapping[str, bytes]:
    found = c99.sources(read_stored(asked.path), asked.prefix, is_float=asked.is_float)
    return {end: text.encode() for end, text in found.items()}


def _matlab(asked: Request) -> Mapping[str, bytes]:
    return matlab.files(read_stored(asked.path), asked.prefix)


EXPORTS = (
    Export("ardupilot", "ArduPilot parameters, NAME,VALUE", (".parm",), _corrected(".parm", ardupilot.text)),
    Export("px4", "PX4 parameters as QGroundControl loads them", (".params",), _corrected(".params", px4.text)),
    Export("kalibr", "Kalibr's imu.yaml, scale-misalignment", (".yaml",), _corrected(".yaml", kalibr.text)),
    Export("imu_calib", "imu_calib of ROS: accelerometers", (".yaml",), _corrected(".yaml", imu_calib.text)),
    Export("c", "C99: a header and a source", (".h", ".c"), _c99),
    Export("matlab", "MATLAB and GNU Octave: a function and its numbers", (".m", ".mat"), _matlab),
)

__all__ = ["EXPORTS", "PREFIX", "Correction", "Export", "NominalScale", "Request", "read_correction"]
