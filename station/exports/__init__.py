"""A calibration written for other programs; one line in `EXPORTS` adds a format.

A receiver's file has a function of a `Correction`, offset and scale about a driver's nominal scale factor, which
returns its text; a program has one of the whole `StoredCalibration` and a `Request`, which returns its files. What
it cannot carry it says in comments.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from station.errors import CannotWrite

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
    """A receiver: its name on the command line, ``file.function`` that writes it, and the ends of its files.

    A program turns counts into results, of double or, where it ``has_float``, of float; any other file corrects
    what a driver made of them.
    """

    name: str
    function: str
    ends: tuple[str, ...]
    is_program: bool = False
    has_float: bool = False

    def files(self, asked: Request) -> Mapping[str, bytes]:
        """Return its files by the end of their names; raise `DataRefused` where it can take none."""
        from station.exports.correction import read_correction  # numerics: not for the list of names
        from station.exports.exported_calibration import read_stored

        module, _, function = self.function.partition(".")
        make = getattr(import_module(f"station.exports.{module}"), function)
        if self.is_program:
            found: Mapping[str, bytes] = make(read_stored(asked.path), asked)
            return found
        return {self.ends[0]: make(read_correction(asked.path, asked.accel, asked.gyro)).encode()}


EXPORTS = (
    Export("c", "c99.files", (".h", ".c"), is_program=True, has_float=True),
    Export("matlab", "matlab.files", (".m", ".mat"), is_program=True),
    Export("px4", "flight_stacks.px4_text", (".params",)),
    Export("ardupilot", "flight_stacks.ardupilot_text", (".parm",)),
    Export("kalibr", "ros.kalibr_text", (".yaml",)),
    Export("imu_calib", "ros.imu_calib_text", (".yaml",)),
)


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

    Raise `CannotWrite` if several files would be one, or a program would have a name that C does not take.
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
