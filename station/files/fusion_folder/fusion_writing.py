"""A fusion folder written: `fusion.toml` with the CSV files of IMU and GNSS."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries, WheelSpeeds
from procedures.geodesy import LocalLevel
from station.files.atomic_file import replace_file
from station.files.fusion_folder.fusion_reading import FUSION_TOML
from station.files.fusion_folder.fusion_schema import LensTable, WheelMountTable
from station.files.fusion_folder.fusion_tables import (
    FORCE_NAMES,
    GNSS_COLUMNS,
    POSITION_NAMES,
    RATE_NAMES,
    VELOCITY_NAMES,
    write_tracks,
    write_wheel,
)

IMU_FILE, GNSS_FILE, TRACKS_FILE, WHEEL_FILE = "imu.csv", "gnss.csv", "tracks.csv", "wheel.csv"
UNKNOWN_STD = 0.1  # s, of a camera's stamps where nothing is stated of them


@dataclass(frozen=True, slots=True, eq=False)
class CameraTracks:
    """What a camera saw, and the camera; where nothing is stated of its time offset that is to be estimated."""

    tracks: FeatureTracks
    lens: LensTable


@dataclass(frozen=True, slots=True, eq=False)
class WheelColumn:
    """What a wheel reported, and how it stands to the IMU."""

    speeds: WheelSpeeds
    mount: WheelMountTable


@dataclass(frozen=True, slots=True, eq=False)
class FusionRecording:
    """What is written: ``gravity`` [m/s2]; ``lever_arm`` (3,) [m] in b, empty where not known.

    ``time_offset_std`` [s] is how well the fixes' times are known by the IMU's clock.
    """

    origin: LocalLevel
    gravity: float
    imu: ImuSeries
    noise: ImuNoise
    fixes: GnssFixes
    time_offset_std: float
    lever_arm: tuple[float, ...] = ()
    seen: CameraTracks | None = None
    wheel: WheelColumn | None = None


def write_fusion(folder: Path, recorded: FusionRecording) -> None:
    """Write a ``fusion/1`` folder, the table last; raise `CannotWrite` where the disk refuses."""
    imu, fixes = recorded.imu, recorded.fixes
    _write(folder / IMU_FILE, ("t_s", *RATE_NAMES, *FORCE_NAMES), np.c_[imu.t, imu.omega_b, imu.f_b])
    columns = ("t_s", *POSITION_NAMES, *VELOCITY_NAMES, "position_std_m", "velocity_std_m_s")
    assert set(columns) <= set(GNSS_COLUMNS.columns)
    rows = np.c_[fixes.t, fixes.p_n, fixes.v_n, fixes.position_std, fixes.velocity_std]
    _write(folder / GNSS_FILE, columns, rows)
    if recorded.seen is not None:
        write_tracks(folder / TRACKS_FILE, recorded.seen.tracks)
    if recorded.wheel is not None:
        write_wheel(folder / WHEEL_FILE, recorded.wheel.speeds)
    replace_file(folder / FUSION_TOML, _table(recorded).encode())


def _write(path: Path, names: tuple[str, ...], rows: FloatArray) -> None:
    """Write rows (n, k); the first column is the time, what is not known an empty cell."""
    text = [",".join(names)]
    for t, *values in rows.tolist():
        text.append(f"{t:.6f}," + ",".join("" if value != value else f"{value:.9g}" for value in values))
    replace_file(path, ("\n".join(text) + "\n").encode())


def _table(recorded: FusionRecording) -> str:
    origin, noise = recorded.origin, recorded.noise
    lines = [
        'format = "fusion/1"',
        "[site]",
        f"latitude_deg = {np.degrees(origin.latitude):.8f}",
        f"longitude_deg = {np.degrees(origin.longitude):.8f}",
        f"height_m = {origin.height:.3f}",
        f"gravity_m_s2 = {recorded.gravity:.6f}",
        "[imu]",
        f'file = "{IMU_FILE}"',
        f"gyro_noise_rad_s_rthz = {noise.gyro:.4e}",
        f"gyro_walk_rad_s2_rthz = {noise.gyro_walk:.4e}",
        f"accel_noise_m_s2_rthz = {noise.accel:.4e}",
        f"accel_walk_m_s3_rthz = {noise.accel_walk:.4e}",
        f"gyro_bias_std_rad_s = {noise.gyro_bias:.4e}",
        f"accel_bias_std_m_s2 = {noise.accel_bias:.4e}",
        "[gnss]",
        f'file = "{GNSS_FILE}"',
        "time_offset_s = 0.0",
        f"time_offset_std_s = {recorded.time_offset_std:g}",
    ]
    if recorded.lever_arm:
        lines.append(f"lever_arm_m = {list(recorded.lever_arm)}")
    if recorded.seen is not None:
        lines.extend(_tracks_table(recorded.seen))
    if recorded.wheel is not None:
        stated = recorded.wheel.mount.model_dump(include=set(WheelMountTable.model_fields))
        lines += [
            "[wheel]",
            f'file = "{WHEEL_FILE}"',
            *(f"{name} = {_toml(each)}" for name, each in stated.items()),
        ]
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _tracks_table(seen: CameraTracks) -> list[str]:
    stated = seen.lens.model_dump(include=set(LensTable.model_fields), exclude_none=True)
    if "time_offset_s" not in stated:
        stated |= {"time_offset_s": 0.0, "time_offset_std_s": UNKNOWN_STD}
    return ["[tracks]", f'file = "{TRACKS_FILE}"', *(f"{name} = {value}" for name, value in stated.items())]
