"""The tables of ``fusion.toml`` (`fusion/1`, docs/how-to/locate.md): names with units, types, ranges, defaults."""

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from station.files.toml_file import PlaceTable, TomlTable

Positive = Annotated[float, Field(gt=0)]
Density = Annotated[float, Field(gt=0, le=10)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Row = Annotated[list[float], Field(min_length=4, max_length=4)]
MAX_ROW_TIME = 5e-4  # s of a row: a quarter of a second for 480 of them
MAX_ROTATION_ERROR = 1e-3  # how far a rotation of a file may be from one, by rounding


def _rigid(rows: list[Row]) -> list[Row]:
    T = np.array(rows)
    C = T[:3, :3]
    turned = np.abs(C @ C.T - np.eye(3)).max() < MAX_ROTATION_ERROR and np.linalg.det(C) > 0
    if not turned or not np.allclose(T[3], [0, 0, 0, 1]):
        raise ValueError("imu_from_camera to be a rotation and a shift, 4x4, last row 0 0 0 1")
    return rows


def _direction(vector: list[float]) -> list[float]:
    if abs(np.linalg.norm(vector) - 1) > MAX_ROTATION_ERROR:
        raise ValueError("forward to be a direction of length 1 in IMU axes, as [1, 0, 0]")
    return vector


Rigid = Annotated[list[Row], Field(min_length=4, max_length=4), AfterValidator(_rigid)]


class FusionImuTable(TomlTable):
    """``[imu]``: the file, noise densities as of the station's Allan analysis, 1 sigma of the biases."""

    file: str
    gyro_noise_rad_s_rthz: Density
    gyro_walk_rad_s2_rthz: Density
    accel_noise_m_s2_rthz: Density
    accel_walk_m_s3_rthz: Density
    gyro_bias_std_rad_s: Annotated[float, Field(gt=0, le=1)] = 0.1
    accel_bias_std_m_s2: Annotated[float, Field(gt=0, le=5)] = 0.15


class FusionGnssTable(TomlTable):
    """``[gnss]``; a column of the same name in the file wins over ``position_std_m`` and ``velocity_std_m_s``."""

    file: str
    position_std_m: Annotated[float, Field(gt=0, le=1000)] | None = None
    velocity_std_m_s: Annotated[float, Field(gt=0, le=100)] | None = None
    lever_arm_m: Vector | None = None
    lever_arm_std_m: Annotated[float, Field(gt=0, le=100)] | None = None
    time_offset_s: Annotated[float, Field(ge=-5, le=5)] | None = None
    time_offset_std_s: Annotated[float, Field(gt=0, le=1)] | None = None


class WheelMountTable(TomlTable):
    """How well a wheel's speed is known, and how it stands to the IMU.

    ``scale_std`` is 1 sigma of the scale factor about 1, ``forward`` where forward is in IMU axes, ``lever_arm_m``
    the way from the IMU to the wheel, or to the middle of the axle. ``signed``: a minus means backwards.
    """

    wheel_std_m_s: Annotated[float, Field(gt=0, le=10)] = 0.05
    scale_std: Annotated[float, Field(gt=0, le=0.5)] = 0.05
    forward: Annotated[Vector, AfterValidator(_direction)] = [1.0, 0.0, 0.0]
    lever_arm_m: Vector = [0.0, 0.0, 0.0]
    signed: bool = False


class WheelTable(WheelMountTable):
    """``[wheel]``: speeds in the column ``wheel_m_s`` of a file, of that of the IMU where none is named."""

    file: str | None = None


class FileTable(TomlTable):
    """``[odometry]`` and ``[truth]``: a TUM file."""

    file: str


class LensTable(TomlTable):
    """A camera: pinhole intrinsics, 1 sigma of an image point, the lens's distortion, where it sits on the IMU.

    ``distortion`` is k1, k2, p1, p2[, k3], as OpenCV has them. ``time_offset_s`` is added to the camera's stamps,
    and estimated about that where it has a sigma. ``row_time_s`` is how much later each row is taken than the one
    above it, the stamp being that of the row ``cy_px``.
    """

    std_px: Positive = 1.0
    fx_px: Positive
    fy_px: Positive
    cx_px: float
    cy_px: float
    distortion: Annotated[list[float], Field(min_length=4, max_length=5)] = [0.0] * 4
    imu_from_camera: Rigid
    time_offset_s: Annotated[float, Field(ge=-5, le=5)] | None = None
    time_offset_std_s: Annotated[float, Field(gt=0, le=0.3)] | None = None
    row_time_s: Annotated[float, Field(ge=-MAX_ROW_TIME, le=MAX_ROW_TIME)] = 0.0


class TracksTable(LensTable):
    """``[tracks]``: image points without distortion; that of the lens is for images yet to be followed."""

    file: str


class FusionTable(TomlTable):
    """The whole of ``fusion.toml``."""

    format: Literal["fusion/1"]
    site: PlaceTable
    imu: FusionImuTable | None = None
    gnss: FusionGnssTable
    odometry: FileTable | None = None
    wheel: WheelTable | None = None
    tracks: TracksTable | None = None
    truth: FileTable | None = None

    @model_validator(mode="after")
    def _has_a_motion(self) -> Self:
        if self.imu is None and self.odometry is None:
            raise ValueError("[imu] or [odometry], or both: what moved between the fixes")
        if self.tracks is not None and self.imu is None:
            raise ValueError("[imu] together with [tracks]")
        if self.wheel is not None and self.imu is None:
            raise ValueError("[imu] together with [wheel]")
        return self
