"""``[wheel]`` of a fusion folder: a vehicle's speed by its wheels, in the IMU's file or one of its own."""

from pathlib import Path

import numpy as np

from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.wheel_speeds import WheelMount, WheelSpeeds
from procedures.units import M_PER_FT, M_S_PER_KM_H, M_S_PER_KNOT, M_S_PER_MPH
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.columns import DataFile
from station.files.fusion_folder.fusion_columns import WHEEL_COLUMNS, WHEEL_NAME, read_table
from station.files.fusion_folder.fusion_schema import WheelMountTable, WheelTable

MIN_COMPARED_M_S = 2.0  # m/s of both, from which a wheel's unit shows beside GNSS's speed
MIN_COMPARED = 20  # fixes
SCALES = (0.6, 1.6)  # of GNSS's speed: no tyre is so far off, but every other unit is
UNITS = {  # in 1 m/s
    "km/h": 1 / M_S_PER_KM_H, "mph": 1 / M_S_PER_MPH, "knots": 1 / M_S_PER_KNOT, "ft/s": 1 / M_PER_FT,
    "cm/s": 100.0, "mm/s": 1000.0,
}  # fmt: skip
MAX_SPEED_M_S = 150.0  # m/s


def mount_of(table: WheelMountTable) -> WheelMount:
    """Return how the wheel stands to the IMU, by its table."""
    forward, lever = np.array(table.forward), np.array(table.lever_arm_m)
    return WheelMount(forward, lever, table.wheel_std_m_s, table.scale_std, table.signed)


def read_wheel(folder: Path, table: WheelTable, line: int, imu: DataFile) -> WheelSpeeds:
    """Read the speeds of ``[wheel]``, at ``line`` of ``fusion.toml``; ``imu`` is the IMU's file as it was read.

    Raises
    ------
    DataRefused
        At the first cell that is no speed, or where there is none at all.
    """
    read = imu
    if table.file is not None and folder / table.file != Path(imu.file):
        read = read_table(folder, table.file, line, WHEEL_COLUMNS)
    if WHEEL_NAME not in read.columns:
        raise DataRefused(
            read.file, 1, f"no column {WHEEL_NAME}", f"a column {WHEEL_NAME}, or a file of [wheel] that has one"
        )
    speed = read.columns[WHEEL_NAME]
    wrong = np.abs(speed) > MAX_SPEED_M_S if table.signed else (speed < 0) | (speed > MAX_SPEED_M_S)
    if len(bad := np.flatnonzero(wrong)):
        expected = f"m/s from {-MAX_SPEED_M_S if table.signed else 0:g} to {MAX_SPEED_M_S:g}"
        may_reverse = not table.signed and speed[bad[0]] < 0
        remedy = "signed = true in [wheel] if negative means backwards" if may_reverse else "correct the file"
        found = f"{WHEEL_NAME} {speed[bad[0]]:g}"
        raise DataRefused(read.file, read.first_line + int(bad[0]), found, expected, remedy)
    told = np.isfinite(speed)
    if not told.any():
        raise DataRefused(read.file, None, f"no speed in column {WHEEL_NAME}", "at least one")
    return WheelSpeeds(read.columns["t_s"][told], speed[told])


def refuse_unit(wheel: WheelSpeeds, fixes: GnssFixes, file: Path) -> None:
    """Refuse speeds that are GNSS's in another unit."""
    gnss = np.hypot(fixes.v_n[:, 0], fixes.v_n[:, 1])
    told = np.abs(np.interp(fixes.t, wheel.t, wheel.speed, left=np.nan, right=np.nan))
    both = (gnss > MIN_COMPARED_M_S) & (told > 0)
    if np.count_nonzero(both) < MIN_COMPARED:
        return
    ratio = float(np.median(told[both] / gnss[both]))
    if not SCALES[0] < ratio < SCALES[1]:
        unit = min(UNITS, key=lambda name: abs(np.log(ratio / UNITS[name])))
        guess = f", as of {unit}" if abs(np.log(ratio / UNITS[unit])) < np.log(1.2) else ""
        raise DataRefused(file, None, f"{WHEEL_NAME} {ratio:.3g} times GNSS's speed{guess}", "a speed in m/s")


def write_wheel(path: Path, wheel: WheelSpeeds) -> None:
    """Write speeds, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = zip(wheel.t.tolist(), wheel.speed.tolist(), strict=True)
    text = "".join(f"{t:.6f},{speed:.5g}\n" for t, speed in rows)
    replace_file(path, (f"t_s,{WHEEL_NAME}\n" + text).encode())
