"""The tables of a fusion folder: CSV files of IMU and GNSS, tracks, wheel speeds, TUM trajectories.

``[tracks]`` are rows ``t_s,feature,u_px,v_px``; ``[wheel]`` a speed in the IMU's file or one of its own; a TUM
trajectory has lines ``t x y z qx qy qz qw``, seconds, metres, a unit quaternion; ``#`` begins a comment.
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import GnssFixes, Trajectory, WheelMount, WheelSpeeds
from procedures.fusion.vision.feature_tracker import LensModel
from procedures.units import M_PER_FT, M_S_PER_KM_H, M_S_PER_KNOT, M_S_PER_MPH
from station.errors import DataRefused
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_schema import LensTable, WheelMountTable, WheelTable
from station.files.opening import open_inside
from station.files.tables.strict_csv import NamedColumns, read_csv
from station.files.tables.table import Table

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


def read_table(folder: Path, name: str, line: int, kind: NamedColumns, repeats: bool = False) -> Table:
    """Read the CSV file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first header, line or cell that breaks a rule, or time that is not above the one before (with
        ``repeats``: below).
    """
    with open_inside(folder, name, folder / "fusion.toml", line) as stream:
        read = read_csv(stream, folder / name, kind)
    refuse_time(read.columns["t_s"], read.line, read.file, repeats)
    return read


def stacked(table: Table, names: Sequence[str]) -> FloatArray:
    """Return columns side by side (n, k), in the file's units; one that is not there is nan."""
    absent = np.full(table.rows, np.nan)
    return np.stack([table.columns.get(name, absent) for name in names], axis=1)


def refuse_time(t: FloatArray, line: Callable[[int], int | None], file: Path, repeats: bool = False) -> None:
    """Refuse a time stamp of ``t`` (n,) [s] that is not above the one before (with ``repeats``: below)."""
    step = np.diff(t)
    bad = np.flatnonzero(~(step >= 0) if repeats else ~(step > 0))
    if len(bad):
        row = int(bad[0]) + 1
        what = "not below" if repeats else "above"
        raise DataRefused(
            file, line(row), f"t_s {t[row]:.6f} after {t[row - 1]:.6f}", f"a time {what} the one before"
        )


TUM_COLUMNS = "t x y z qx qy qz qw"
MAX_NORM_ERROR = 1e-3  # how far a quaternion of a file may be from unit length, by rounding


def read_tum(folder: Path, name: str, line: int) -> Trajectory:
    """Read the TUM file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first line that is not eight numbers, a time that runs back, or a quaternion that is not one.
    """
    path = folder / name
    with open_inside(folder, name, folder / "fusion.toml", line) as stream:
        text = stream.read().decode("utf-8", "backslashreplace")
    rows, lines = list[list[float]](), list[int]()
    for number, content in enumerate(text.splitlines(), start=1):
        if content.strip() and not content.lstrip().startswith("#"):
            rows.append(_numbers(content, path, number))
            lines.append(number)
    if len(rows) < 2:
        raise DataRefused(path, None, f"{len(rows)} poses", f"at least two lines {TUM_COLUMNS}")
    values = np.array(rows)
    refuse_time(values[:, 0], lines.__getitem__, path)
    length = np.linalg.norm(values[:, 4:], axis=1)
    if len(bad := np.flatnonzero(np.abs(length - 1) > MAX_NORM_ERROR)):
        found = f"a quaternion of length {length[bad[0]]:.4g}"
        raise DataRefused(path, lines[bad[0]], found, f"{TUM_COLUMNS} with a quaternion of length 1")
    return Trajectory(values[:, 0], values[:, 1:4], values[:, 4:] / length[:, None])


def _numbers(content: str, path: Path, number: int) -> list[float]:
    try:
        values = [float(cell) for cell in content.split()]
    except ValueError:
        values = []
    if len(values) != 8 or not np.all(np.isfinite(values)):
        raise DataRefused(path, number, repr(content[:60]), f"eight numbers: {TUM_COLUMNS}")
    return values


def write_tum(path: Path, trajectory: Trajectory) -> None:
    """Write a trajectory, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = np.hstack((trajectory.t[:, None], trajectory.p, trajectory.q))
    text = "".join(f"{r[0]:.6f} " + " ".join(f"{v:.7f}" for v in r[1:]) + "\n" for r in rows.tolist())
    replace_file(path, text.encode())


LARGEST = 2.0**53  # of a feature's number


def camera_of(table: LensTable) -> PinholeCamera:
    """Return the camera that a table describes."""
    T = np.array(table.imu_from_camera)
    place, row = (T[:3, :3], T[:3, 3]), table.row_time_s
    return PinholeCamera(table.fx_px, table.fy_px, table.cx_px, table.cy_px, table.std_px, *place, row)


def lens_of(table: LensTable) -> LensModel:
    """Return the lens that a table describes."""
    return LensModel(table.fx_px, table.fy_px, table.cx_px, table.cy_px, np.array(table.distortion))


def read_tracks(folder: Path, name: str, line: int) -> FeatureTracks:
    """Read the tracks file ``name`` of ``folder`` that stands at ``line`` of ``fusion.toml``.

    Raises
    ------
    DataRefused
        At the first cell that is no number, time that runs back, or feature that is none or twice in a frame.
    """
    read = read_table(folder, name, line, TRACKS_COLUMNS, repeats=True)
    t, feature = read.columns["t_s"], read.columns["feature"]
    _refuse_features(read)
    return FeatureTracks(t, feature.astype(np.int64), stacked(read, ("u_px", "v_px")))


def _refuse_features(read: Table) -> None:
    t, feature, line, file = read.columns["t_s"], read.columns["feature"], read.line, read.file
    wrong = np.flatnonzero((feature != np.floor(feature)) | (feature < 0) | (feature >= LARGEST))
    if len(wrong):
        raise DataRefused(file, line(int(wrong[0])), f"feature {feature[wrong[0]]:g}", "a whole number from 0 on")
    order = np.lexsort((feature, t))
    twice = np.flatnonzero((np.diff(t[order]) == 0) & (np.diff(feature[order]) == 0))
    if len(twice):
        row = int(order[twice + 1].min())
        raise DataRefused(
            file, line(row), f"feature {feature[row]:.0f} again at t_s {t[row]:.6f}", "each feature once a frame"
        )


def write_tracks(path: Path, tracks: FeatureTracks) -> None:
    """Write tracks, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = zip(tracks.t.tolist(), tracks.feature.tolist(), tracks.uv.tolist(), strict=True)
    text = "".join(f"{t:.6f},{feature},{u:.3f},{v:.3f}\n" for t, feature, (u, v) in rows)
    replace_file(path, ("t_s,feature,u_px,v_px\n" + text).encode())


MIN_COMPARED_M_S = 2.0  # m/s of both, from which a wheel's unit can be compared with GNSS's speed
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


def read_wheel(folder: Path, table: WheelTable, line: int, imu: Table) -> WheelSpeeds:
    """Read the speeds of ``[wheel]``, at ``line`` of ``fusion.toml``; ``imu`` is the IMU's file as it was read.

    Raises
    ------
    DataRefused
        At the first cell that is no speed, or where there is none at all.
    """
    read = imu
    if table.file is not None and folder / table.file != imu.file:
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
        raise DataRefused(read.file, read.line(int(bad[0])), found, expected, remedy)
    stated = np.isfinite(speed)
    if not stated.any():
        raise DataRefused(read.file, None, f"no speed in column {WHEEL_NAME}", "at least one")
    return WheelSpeeds(read.columns["t_s"][stated], speed[stated])


def refuse_unit(wheel: WheelSpeeds, fixes: GnssFixes, file: Path) -> None:
    """Refuse speeds that are GNSS's in another unit."""
    gnss = np.hypot(fixes.v_n[:, 0], fixes.v_n[:, 1])
    stated = np.abs(np.interp(fixes.t, wheel.t, wheel.speed, left=np.nan, right=np.nan))
    both = (gnss > MIN_COMPARED_M_S) & (stated > 0)
    if np.count_nonzero(both) < MIN_COMPARED:
        return
    ratio = float(np.median(stated[both] / gnss[both]))
    if not SCALES[0] < ratio < SCALES[1]:
        unit = min(UNITS, key=lambda name: abs(np.log(ratio / UNITS[name])))
        guess = f", as of {unit}" if abs(np.log(ratio / UNITS[unit])) < np.log(1.2) else ""
        raise DataRefused(file, None, f"{WHEEL_NAME} {ratio:.3g} times GNSS's speed{guess}", "a speed in m/s")


def write_wheel(path: Path, wheel: WheelSpeeds) -> None:
    """Write speeds, there whole or what stood there before; raise `CannotWrite` if it cannot be."""
    rows = zip(wheel.t.tolist(), wheel.speed.tolist(), strict=True)
    text = "".join(f"{t:.6f},{speed:.5g}\n" for t, speed in rows)
    replace_file(path, (f"t_s,{WHEEL_NAME}\n" + text).encode())
