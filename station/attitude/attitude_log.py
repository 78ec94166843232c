"""`attitude-log/1` (docs/explanation/attitude.md) read; the first rule that it breaks is named with its line."""

from pathlib import Path

import numpy as np

from procedures.arrays import BoolArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.error_codes import ErrorCode
from station.attitude.log_checks import LogPlace, check_motion
from station.errors import DataRefused
from station.files.columns import DataFile
from station.files.csv_header import NamedColumns
from station.files.csv_table import read_csv
from station.files.opening import open_inside

RATES = ("p_rad_s", "q_rad_s", "r_rad_s")
FORCES = ("fx_m_s2", "fy_m_s2", "fz_m_s2")
VELOCITY = ("vn_m_s", "ve_m_s", "vd_m_s")
TRUTH = ("roll_rad", "pitch_rad")
NEEDED = ("t_s", *RATES, *FORCES)
MAX_RATE_RAD_S = 87.0  # rad/s, 5000 deg/s: no gyro measures more
MAX_FORCE_M_S2 = 5000.0  # m/s2
MAX_HEADER = 10_000  # bytes
SAMPLE_PERIOD_RANGE_S = 1e-5, 1.0  # s: no IMU samples faster, and none slower can be followed
MAX_AID_VALUES = {  # of what is no sensor of the IMU: the largest value, and what a larger one looks like
    "airspeed_m_s": (3000.0, ""), **dict.fromkeys(VELOCITY, (10000.0, "")), "heading_rad": (4 * np.pi, "deg"),
    "roll_rad": (2 * np.pi, "deg"), "pitch_rad": (1.5709, "deg"),
}  # fmt: skip


def is_attitude_log(path: Path) -> bool:
    """Say whether a first line names rates as attitude-log/1 does; also of a file that is not there."""
    if not path.is_file():
        return True
    with path.open("rb") as stream:
        names = stream.readline(MAX_HEADER).decode("utf-8", "replace").strip().split(",")
    return sum(name.strip() in RATES for name in names) > 1


LOG_COLUMNS = NamedColumns(NEEDED, ("airspeed_m_s", *VELOCITY, "heading_rad", *TRUTH, "scored"), (VELOCITY, TRUTH))


def read_log(path: Path, notes: list[str] | None = None) -> AttitudeLog:
    """Read a log; what is odd about it, but may be right, is added to ``notes`` in words.

    Raises
    ------
    DataRefused
        If a column is missing or unknown, a cell is no number, time does not go forward, a rate is beyond any
        gyro, gravity is not in the specific force, or gyros and accelerometers disagree on how it turns.
    """
    if not path.exists():
        raise DataRefused(
            path,
            None,
            "no such file",
            "a CSV file of attitude-log/1",
            "name one that is there",
            code=ErrorCode.FILE_MISSING,
        )
    with open_inside(path.parent, path.name, path, None) as stream:
        table = read_csv(stream, path, LOG_COLUMNS)
    _check_time(table)
    _check_size(table)
    log = _log(table)
    found = check_motion(log, LogPlace(table.file, table.line))
    if notes is not None:
        notes += found
    return log


def _log(table: DataFile) -> AttitudeLog:
    columns = table.columns
    velocity = np.stack([columns[name] for name in VELOCITY], axis=1) if VELOCITY[0] in columns else None
    return AttitudeLog(
        t=columns["t_s"],
        omega_b=np.stack([columns[name] for name in RATES], axis=1),
        f_b=np.stack([columns[name] for name in FORCES], axis=1),
        airspeed=columns.get("airspeed_m_s"), velocity=velocity, heading=columns.get("heading_rad"),
        roll=columns.get("roll_rad"), pitch=columns.get("pitch_rad"), scored=_scored(table),
    )  # fmt: skip


def _scored(table: DataFile) -> BoolArray | None:
    scored = table.columns.get("scored")
    if scored is None:
        return None
    bad = np.flatnonzero(~np.isnan(scored) & (scored != 0) & (scored != 1))
    if len(bad):
        found = f"scored = {scored[bad[0]]:g}"
        raise DataRefused(table.file, table.line(bad[0]), found, "0 or 1")
    return np.asarray(scored == 1)


def _check_time(table: DataFile) -> None:
    t = table.columns["t_s"]
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        row = int(back[0]) + 1
        found = f"t_s {t[row]:.9g} after {t[row - 1]:.9g}"
        remedy = "remove the row, or sort the file" if t[row] < t[row - 1] else "remove the repeated row"
        raise DataRefused(table.file, table.line(row), found, "a later time", remedy)
    if len(t) < 2:
        raise DataRefused(table.file, table.line(0), "a single row", "at least two rows")
    step = float(np.median(np.diff(t)))
    if not SAMPLE_PERIOD_RANGE_S[0] <= step <= SAMPLE_PERIOD_RANGE_S[1]:
        found = f"t_s going by {step:.3g} a row" + (": looks like ms or less" if step > 1 else "")
        raise DataRefused(
            table.file, table.line(1), found, "seconds, a row at least each", "convert t_s to seconds"
        )


def _check_size(table: DataFile) -> None:
    for names, most, unit, guess in (
        (RATES, MAX_RATE_RAD_S, "rad/s", "deg/s"),
        (FORCES, MAX_FORCE_M_S2, "m/s2", "mg"),
    ):
        for name in names:
            _check_column(table, name, most, f"beyond any sensor's range: looks like {guess}", unit)
    for name, (most, guess) in MAX_AID_VALUES.items():
        if name in table.columns:
            said = f"beyond {most:.4g}" + (f": looks like {guess}" if guess else "")
            _check_column(table, name, most, said, "rad" if guess else "m/s")


def _check_column(table: DataFile, name: str, most: float, said: str, unit: str) -> None:
    values = table.columns[name]
    beyond = np.flatnonzero(np.abs(values) > most)
    if len(beyond):
        found = f"{name} = {values[beyond[0]]:g}, {said}"
        raise DataRefused(table.file, table.line(int(beyond[0])), found, unit, f"convert the column to {unit}")
