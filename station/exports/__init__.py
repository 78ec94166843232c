"""A calibration written for other programs; one line in `EXPORTS` adds a format.

A receiver's file makes texts of a `Correction`, offset and scale about a driver's nominal scale factor, or of the
whole `StoredCalibration`. What it cannot carry it says in comments.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from station.errors import CannotWrite
from station.exports import c99, matlab
from station.exports.correction import Correction, NominalScale, read_correction
from station.exports.exported_calibration import read_stored
from station.exports.flight_stacks import ardupilot_text, px4_text
from station.exports.ros import imu_calib_text, kalibr_text

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
    Export("ardupilot", "ArduPilot parameters, NAME,VALUE", (".parm",), _corrected(".parm", ardupilot_text)),
    Export("px4", "PX4 parameters as QGroundControl loads them", (".params",), _corrected(".params", px4_text)),
    Export("kalibr", "Kalibr's imu.yaml, scale-misalignment", (".yaml",), _corrected(".yaml", kalibr_text)),
    Export("imu_calib", "imu_calib of ROS: accelerometers", (".yaml",), _corrected(".yaml", imu_calib_text)),
    Export("c", "C99: a header and a source", (".h", ".c"), _c99),
    Export("matlab", "MATLAB and GNU Octave: a function and its numbers", (".m", ".mat"), _matlab),
)

__all__ = ["EXPORTS", "PREFIX", "Correction", "Export", "NominalScale", "Request", "read_correction"]


_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}", re.ASCII)
C_WORDS = frozenset(
    (
        "auto break case char const continue default do double else enum extern float for goto if inline int long "
        "main register restrict return short signed sizeof static struct switch typedef union unsigned void "
        "volatile while"
    ).split()
)


def export_paths(export: Export, out: Path) -> tuple[str, dict[str, Path]]:
    """Return the name of an export, and the path of each of its files by the end of its name.

    ``out`` is a folder, made if it is not there, or a file whose name without its end is taken.

    Raises
    ------
    CannotWrite
        If several files would be one, or a program would have a name that C does not take.
    """
    if len(export.ends) == 1 and not out.is_dir():
        return PREFIX, {export.ends[0]: out}
    is_file = out.suffix in export.ends and not out.is_dir()
    if not is_file and out.suffix and not out.is_dir():
        raise CannotWrite(out, f"{export.name} writes {' and '.join(f'NAME{end}' for end in export.ends)}")
    name, folder = (out.stem, out.parent) if is_file else (PREFIX, out)
    if not _IDENTIFIER.fullmatch(name) or name in C_WORDS:
        raise CannotWrite(out, f"{name} is no name for a program: letters, digits and _, up to 31")
    return name, {end: folder / f"{name}{end}" for end in export.ends}
