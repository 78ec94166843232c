"""The header of a data file: which columns there may be, and what their cells hold."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from station.errors import DataRefused
from station.files.columns import OUTPUTS, TRIADS

_AUX = re.compile(r"aux_[A-Za-z0-9_]+")
_SAMPLE_COLUMNS = ("t_s", *OUTPUTS, "temp_c", "utc_s", "aux_NAME")
_TURNTABLE_COLUMNS = ("rate_ref_deg_s", "t_s", *TRIADS["gyro"], "temp_c")


@dataclass(frozen=True, slots=True)
class NamedColumns:
    """What a file's header must hold, and what it may hold besides, whose cells may be empty.

    Of each group of columns ``together`` all are there or none.
    """

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()
    together: tuple[tuple[str, ...], ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that may be there."""
        return (*self.needed, *self.optional)

    def cell(self, name: str) -> str:
        """Return what a cell of a column holds, in words."""
        return "a number" if name in self.needed else "a number or nothing"

    def check(self, names: list[str], file: Path) -> None:
        """Refuse a file that lacks a column, or has only a part of a group."""
        for name in self.needed:
            if name not in names:
                raise DataRefused(file, 1, f"no column {name}", f"the columns {','.join(self.needed)}")
        _refuse_part(self.together, names, file)


@dataclass(frozen=True, slots=True)
class SampleColumns:
    """What a data file holds: a row per sample, or a row per point of a turntable; counts or reals."""

    counts: bool
    rate_table: bool = False

    @property
    def time(self) -> str:
        """The column that must be there."""
        return "rate_ref_deg_s" if self.rate_table else "t_s"

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that may be there."""
        return _TURNTABLE_COLUMNS if self.rate_table else _SAMPLE_COLUMNS

    def cell(self, name: str) -> str:
        """Return what a cell of a column holds, in words."""
        if name in {self.time, "t_s"}:
            return "a number"
        if name in OUTPUTS:
            return "an integer" if self.counts and not self.rate_table else "a number"
        return "a number or nothing"

    def check(self, names: list[str], file: Path) -> None:
        """Refuse a file that lacks its time or reference column, or has no triad or only a part of one."""
        if self.time not in names:
            raise DataRefused(file, 1, f"no column {self.time}", f"a column {self.time}")
        if not self.rate_table:
            _refuse_part(TRIADS.values(), names, file)
        if not any(name in names for name in OUTPUTS):
            raise DataRefused(file, 1, "no output column", "gx,gy,gz or ax,ay,az")


def _refuse_part(groups: Iterable[tuple[str, ...]], names: list[str], file: Path) -> None:
    for group in groups:
        there = [name for name in group if name in names]
        if there and len(there) < len(group):
            raise DataRefused(file, 1, f"only {','.join(there)}", f"all of {','.join(group)} or none")


def read_header(header: bytes, file: Path, kind: NamedColumns | SampleColumns) -> dict[str, str]:
    """Return the columns of a header line in their order, each with what its cells hold.

    Raises
    ------
    DataRefused
        If a column is unknown, missing or double.
    """
    expected = f"columns out of {','.join(kind.columns)}"
    if header.startswith(b"\xef\xbb\xbf"):
        raise DataRefused(file, 1, "a byte order mark", "plain UTF-8 that begins with the header")
    if not header.strip():
        raise DataRefused(file, 1, "no header", expected)
    names = header.removesuffix(b"\r").decode("utf-8", "backslashreplace").split(",")
    for index, name in enumerate(names):
        known = name in kind.columns and name != "aux_NAME"
        if not known and not ("aux_NAME" in kind.columns and _AUX.fullmatch(name)):
            raise DataRefused(file, 1, f"column {name[:40]!a}", expected)
        if name in names[:index]:
            raise DataRefused(file, 1, f"column {name} twice", "each column once")
    kind.check(names, file)
    return {name: kind.cell(name) for name in names}
