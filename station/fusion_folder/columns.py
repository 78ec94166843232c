"""The CSV files of a fusion folder: which columns there are, read with the line of the first that is wrong."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.campaign_folder.csv_table import read_columns
from station.campaign_folder.files import open_inside
from station.campaign_folder.table import Table
from station.errors import DataRefused

RATE = ("wx_rad_s", "wy_rad_s", "wz_rad_s")
FORCE = ("fx_m_s2", "fy_m_s2", "fz_m_s2")
POSITION = ("e_m", "n_m", "u_m")
VELOCITY = ("ve_m_s", "vn_m_s", "vu_m_s")


@dataclass(frozen=True, slots=True)
class Columns:
    """What a file's header must hold, and what it may hold besides; those cells may be empty."""

    needed: tuple[str, ...]
    optional: tuple[str, ...] = ()


IMU = Columns(("t_s", *RATE, *FORCE))
GNSS = Columns(("t_s", *POSITION), (*VELOCITY, "course_rad", "position_std_m", "velocity_std_m_s"))
TRACKS = Columns(("t_s", "feature", "u_px", "v_px"))


def read_table(folder: Path, name: str, line: int, columns: Columns) -> Table:
    """Read the CSV file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first header, line or cell that breaks a rule.
    """
    path = folder / name
    with open_inside(folder, name, folder / "fusion.toml", line) as stream:
        return read_columns(stream, path, lambda header: _cells(header, path, columns))


def _cells(header: bytes, path: Path, columns: Columns) -> dict[str, str]:
    names = header.removesuffix(b"\r").decode("utf-8", "backslashreplace").split(",")
    expected = ",".join(columns.needed) + "".join(f"[,{name}]" for name in columns.optional)
    for name in columns.needed:
        if name not in names:
            raise DataRefused(path, 1, f"no column {name}", expected)
    for index, name in enumerate(names):
        if name not in (*columns.needed, *columns.optional):
            raise DataRefused(path, 1, f"column {name[:40]!a}", expected)
        if name in names[:index]:
            raise DataRefused(path, 1, f"column {name} twice", "each column once")
    if len({"ve_m_s", "vn_m_s"} & set(names)) == 1:
        raise DataRefused(path, 1, "half of a horizontal velocity", "both of ve_m_s and vn_m_s, or neither")
    return {name: "a number" if name in columns.needed else "a number or nothing" for name in names}


def stacked(table: Table, names: Sequence[str]) -> FloatArray:
    """Return columns side by side (n, k); one that is not there is nan."""
    absent = np.full(table.rows, np.nan)
    return np.stack([table.columns.get(name, absent) for name in names], axis=1)


def refuse_time(t: FloatArray, line: Sequence[int] | int, file: str | Path, repeats: bool = False) -> None:
    """Refuse a time stamp that is not above the one before (with ``repeats``: below)."""
    step = np.diff(t)
    bad = np.flatnonzero(~(step >= 0) if repeats else ~(step > 0))
    if len(bad):
        row = int(bad[0]) + 1
        at = line + row if isinstance(line, int) else line[row]
        what = "not below" if repeats else "above"
        raise DataRefused(file, at, f"t_s {t[row]:.6f} after {t[row - 1]:.6f}", f"a time {what} the one before")
