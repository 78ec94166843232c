"""A fusion folder read into memory; units that cannot be, and clocks that do not meet, are refused."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries, Trajectory, WheelSpeeds
from procedures.geodesy import normal_gravity
from station.errors import DataRefused
from station.files.fusion_folder.fusion_schema import FusionGnssTable, FusionTable
from station.files.fusion_folder.fusion_tables import (
    FORCE_NAMES,
    GNSS_COLUMNS,
    IMU_COLUMNS,
    POSITION_NAMES,
    RATE_NAMES,
    VELOCITY_NAMES,
    WHEEL_NAME,
    camera_of,
    read_table,
    read_tracks,
    read_tum,
    read_wheel,
    refuse_unit,
    stacked,
)
from station.files.toml_file import Key, line_of, read_folder_toml

MEDIAN_FORCE_RANGE_M_S2 = (4.0, 25.0)  # m/s2 that the median of |f| keeps within, in any vehicle that comes back
MAX_RATE_RAD_S = 35.0  # rad/s: 2000 deg/s, the range of the IMUs that are located
MAX_FORCE_M_S2 = 5000.0  # m/s2, 500 g: beyond the range of any of them
MAX_DISTANCE_M = 1e7  # m, of a fix from the origin of its own level frame
# rad/s rms over a whole recording: half a turn a second, always; the wildest flights at hand have 0.9
MAX_RMS_RATE_RAD_S = 3.0


def refuse_units(imu: ImuSeries, file: Path) -> None:
    """Refuse specific force that holds no gravity, and rates that no vehicle turns at: those are g and deg/s."""
    peak = float(np.abs(imu.f_b).max())
    if peak > MAX_FORCE_M_S2:
        raise DataRefused(file, None, f"specific force up to {peak:.4g} m/s2", f"at most {MAX_FORCE_M_S2:g}")
    size = float(np.median(np.linalg.norm(imu.f_b, axis=1)))
    if not MEDIAN_FORCE_RANGE_M_S2[0] < size < MEDIAN_FORCE_RANGE_M_S2[1]:
        unit = "g" if 0.5 < size < 2 else "mg" if 500 < size < 2000 else "another unit than m/s2"
        raise DataRefused(
            file, None, f"a median |f| of {size:.4g}, as of {unit}", "specific force in m/s2, near 9.8"
        )
    rate = np.linalg.norm(np.clip(imu.omega_b, -1e9, 1e9), axis=1)
    rms, peak = float(np.sqrt(np.mean(rate**2))), float(rate.max())
    if peak > MAX_RATE_RAD_S or rms > MAX_RMS_RATE_RAD_S:
        found = f"rates of {rms:.3g} rms and up to {peak:.3g}, as of deg/s"
        raise DataRefused(
            file, None, found, f"angular rate in rad/s, below {MAX_RMS_RATE_RAD_S:g} rms and {MAX_RATE_RAD_S:g}"
        )


def refuse_far(fixes: GnssFixes, file: Path) -> None:
    """Refuse fixes that no level frame reaches: those are of an Earth-centred one, or in another unit."""
    far = float(np.abs(fixes.p_n).max())
    if far > MAX_DISTANCE_M:
        raise DataRefused(file, None, f"a position {far:.4g} m away", "metres East, North, Up of a place near by")


def refuse_apart(fixes: GnssFixes, t: FloatArray, what: str, file: Path) -> None:
    """Refuse fixes that do not overlap with the times ``t`` (n,) [s] of what moved between them, or of a truth."""
    if not (fixes.t[0] < t[-1] and fixes.t[-1] > t[0]):
        found = f"GNSS from {fixes.t[0]:.3f} to {fixes.t[-1]:.3f} s and {what} from {t[0]:.3f} to {t[-1]:.3f} s"
        raise DataRefused(file, None, found, "times of one clock that overlap")


FUSION_TOML = "fusion.toml"


@dataclass(frozen=True, slots=True, eq=False)
class FusionLog:
    """A folder's content: what is not in it is None. ``latitude`` [rad], ``gravity`` [m/s2]."""

    folder: Path
    table: FusionTable
    latitude: float
    gravity: float
    fixes: GnssFixes
    imu: ImuSeries | None
    noise: ImuNoise | None
    odometry: Trajectory | None
    truth: Trajectory | None
    tracks: FeatureTracks | None = None
    camera: PinholeCamera | None = None
    wheel: WheelSpeeds | None = None


def read_fusion(folder: Path) -> FusionLog:
    """Read a ``fusion/1`` folder.

    Raise `DataRefused` if the folder breaks a rule of docs/how-to/locate.md: with file, line, found and expected.
    """
    table, lines = read_fusion_toml(folder)
    fixes = _fixes(folder, table.gnss, lines)
    imu, wheel = _imu(folder, table, lines)
    odometry = _trajectory(folder, table, "odometry", lines)
    truth = _trajectory(folder, table, "truth", lines)
    refuse_far(fixes, folder / table.gnss.file)
    for moved, what in ((imu, "IMU"), (odometry, "odometry"), (truth, "truth"), (wheel, "wheel")):
        if moved is not None:
            refuse_apart(fixes, moved.t, what, folder / table.gnss.file)
    latitude = float(np.radians(table.site.latitude_deg))
    gravity = table.site.gravity_m_s2 or normal_gravity(latitude, table.site.height_m)
    tracks, camera = _camera(folder, table, lines, fixes)
    if wheel is not None and table.wheel is not None and table.imu is not None:
        refuse_unit(wheel, fixes, folder / (table.wheel.file or table.imu.file))
    return FusionLog(
        folder, table, latitude, gravity, fixes, imu, _noise(table), odometry, truth, tracks, camera, wheel
    )


def read_fusion_toml(folder: Path) -> tuple[FusionTable, dict[Key, int]]:
    """Return the tables of a folder, and the line of each key; refuse what breaks a rule."""
    tables, lines, _ = read_folder_toml(folder, FUSION_TOML, FusionTable)
    return tables, lines


def files_of(folder: Path, but: str = "") -> list[Path]:
    """Return the files that a folder consists of, there or not, without that of the table ``but``."""
    table, _ = read_fusion_toml(folder)
    parts = (
        getattr(table, name) for name in ("imu", "gnss", "odometry", "wheel", "tracks", "truth") if name != but
    )
    return [folder / FUSION_TOML, *(folder / part.file for part in parts if part is not None and part.file)]


def _imu(folder: Path, table: FusionTable, lines: dict[Key, int]) -> tuple[ImuSeries | None, WheelSpeeds | None]:
    if table.imu is None:
        return None, None
    read = read_table(folder, table.imu.file, line_of(("imu", "file"), lines), IMU_COLUMNS)
    imu = ImuSeries(read.columns["t_s"], stacked(read, RATE_NAMES), stacked(read, FORCE_NAMES))
    refuse_units(imu, folder / table.imu.file)
    if table.wheel is not None:
        return imu, read_wheel(folder, table.wheel, line_of(("wheel", "file"), lines), read)
    if WHEEL_NAME in read.columns:
        raise DataRefused(read.file, 1, f"a column {WHEEL_NAME}", "a table [wheel] that says where forward is")
    return imu, None


def _camera(
    folder: Path, table: FusionTable, lines: dict[Key, int], fixes: GnssFixes
) -> tuple[FeatureTracks | None, PinholeCamera | None]:
    if table.tracks is None:
        return None, None
    tracks = read_tracks(folder, table.tracks.file, line_of(("tracks", "file"), lines))
    refuse_apart(fixes, tracks.t, "tracks", folder / table.gnss.file)
    return tracks, camera_of(table.tracks)


def _noise(table: FusionTable) -> ImuNoise | None:
    if (imu := table.imu) is None:
        return None
    return ImuNoise(
        imu.gyro_noise_rad_s_rthz,
        imu.gyro_walk_rad_s2_rthz,
        imu.accel_noise_m_s2_rthz,
        imu.accel_walk_m_s3_rthz,
        imu.gyro_bias_std_rad_s,
        imu.accel_bias_std_m_s2,
    )


def _fixes(folder: Path, gnss: FusionGnssTable, lines: dict[Key, int]) -> GnssFixes:
    read = read_table(folder, gnss.file, line_of(("gnss", "file"), lines), GNSS_COLUMNS)
    file = folder / gnss.file
    position_std = _std(read.columns.get("position_std_m"), gnss.position_std_m, read.rows, "position_std_m", file)
    v_n = stacked(read, VELOCITY_NAMES)
    course = read.columns.get("course_rad", np.full(read.rows, np.nan))
    if np.isfinite(v_n[:, 0]).any() or np.isfinite(course).any():
        given = read.columns.get("velocity_std_m_s")
        velocity_std = _std(given, gnss.velocity_std_m_s, read.rows, "velocity_std_m_s", file)
    else:
        velocity_std = np.full(read.rows, np.nan)
    return GnssFixes(read.columns["t_s"], stacked(read, POSITION_NAMES), v_n, course, position_std, velocity_std)


def _std(column: FloatArray | None, table: float | None, rows: int, name: str, file: Path) -> FloatArray:
    """Return 1 sigma of each row: the cell, else the table's value."""
    std = np.full(rows, np.nan) if column is None else column
    std = np.where(np.isfinite(std), std, np.nan if table is None else table)
    if len(bad := np.flatnonzero(~(std > 0))):
        found = "no value" if np.isnan(std[bad[0]]) else f"{std[bad[0]]:g}"
        raise DataRefused(file, 2 + int(bad[0]), f"{name}: {found}", f"a {name} above 0 here or in [gnss]")
    return std


def _trajectory(folder: Path, table: FusionTable, name: str, lines: dict[Key, int]) -> Trajectory | None:
    part = getattr(table, name)
    return part and read_tum(folder, part.file, line_of((name, "file"), lines))
