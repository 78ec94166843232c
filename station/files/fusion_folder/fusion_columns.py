"""The CSV files of a fusion folder: which columns there are, read with the line of the first that is wrong."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.columns import DataFile
from station.files.csv_header import NamedColumns
from station.files.csv_table import read_csv
from station.files.opening import open_inside

RATE_NAMES = ("wx_rad_s", "wy_rad_s", "wz_rad_s")
FORCE_NAMES = ("fx_m_s2", "fy_m_s2", "fz_m_s2")
POSITION_NAMES = ("e_m", "n_m", "u_m")
VELOCITY_NAMES = ("ve_m_s", "vn_m_s", "vu_m_s")


class GnssColumns(NamedColumns):
    """The columns of fixes: a horizontal velocity is there whole or not at all."""

    def check(self, names: list[str], file: Path) -> None:
        """Refuse a file that lacks a column, or has half of a horizontal velocity."""
        super().check(names, file)
        if len({"ve_m_s", "vn_m_s"} & set(names)) == 1:
            raise DataRefused(file, 1, "half of a horizontal velocity", "both of ve_m_s and vn_m_s, or neither")


WHEEL_NAME = "wheel_m_s"
IMU_COLUMNS = NamedColumns(("t_s", *RATE_NAMES, *FORCE_NAMES), (WHEEL_NAME,))
WHEEL_COLUMNS = NamedColumns(("t_s", WHEEL_NAME))
GNSS_COLUMNS = GnssColumns(
    ("t_s", *POSITION_NAMES), (*VELOCITY_NAMES, "course_rad", "position_std_m", "velocity_std_m_s")
)
TRACKS_COLUMNS = NamedColumns(("t_s", "feature", "u_px", "v_px"))


def read_table(folder: Path, name: str, line: int, kind: NamedColumns, repeats: bool = False) -> DataFile:
    """Read the CSV file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first header, line or cell that breaks a rule, or time that is not above the one before (with
        ``repeats``: below).
    """
    with open_inside(folder, name, folder / "fusion.toml", line) as stream:
        read = read_csv(stream, folder / name, kind)
    refuse_time(read.columns["t_s"], read.first_line, read.file, repeats)
    return read


def stacked(table: DataFile, names: Sequence[str]) -> FloatArray:
    """Return columns side by side (n, k), in the file's units; one that is not there is nan."""
    absent = np.full(table.rows, np.nan)
    return np.stack([table.columns.get(name, absent) for name in names], axis=1)


def refuse_time(t: FloatArray, line: Sequence[int] | int, file: str | Path, repeats: bool = False) -> None:
    """Refuse a time stamp of ``t`` (n,) [s] that is not above the one before (with ``repeats``: below)."""
    step = np.diff(t)
    bad = np.flatnonzero(~(step >= 0) if repeats else ~(step > 0))
    if len(bad):
        row = int(bad[0]) + 1
        at = line + row if isinstance(line, int) else line[row]
        what = "not below" if repeats else "above"
        raise DataRefused(file, at, f"t_s {t[row]:.6f} after {t[row - 1]:.6f}", f"a time {what} the one before")
