"""What locating a folder gives."""

from dataclasses import dataclass

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import Trajectory


@dataclass(frozen=True, slots=True)
class Alignment:
    """How the source's frame was found to stand against n at the start; degrees, what is not known is None."""

    yaw_deg: float
    yaw_std_deg: float
    tilt_deg: float | None = None
    tilt_std_deg: float | None = None


@dataclass(frozen=True, slots=True)
class WheelFound:
    """A wheel's scale factor with 1 sigma, when it slipped (from, to) [s], and how long the vehicle stood [s]."""

    scale: float
    scale_std: float
    slips: tuple[tuple[float, float], ...]
    rest_s: float


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """``online``: each pose uses nothing later; ``smoothed``: all poses by all fixes.

    ``covariance`` (n, 4, 4) is that of the online poses: position [m] and heading [rad] in n.
    ``begun_at`` [s] is None where it never could, and ``why_not`` says why. ``seconds`` (n,): how long each online
    pose took. ``layers`` is what was used, ``rejected`` of ``fixes`` stand
    off the smoothed trajectory. Biases and ``time_offset`` are the last; what was neither given nor
    estimated is None. ``camera_time_offset`` [s] is that of the camera's stamps, with 1 sigma where it was
    estimated.
    """

    online: Trajectory
    smoothed: Trajectory
    begun_at: float | None
    why_not: str
    rejected: int
    seconds: FloatArray
    alignment: Alignment | None = None
    gyro_bias: FloatArray | None = None
    accel_bias: FloatArray | None = None
    lever_arm: FloatArray | None = None
    time_offset: float | None = None
    camera_time_offset: float | None = None
    camera_time_offset_std: float | None = None
    warnings: tuple[str, ...] = ()
    layers: int = 2
    covariance: FloatArray | None = None
    fixes: int = 0
    wheel: WheelFound | None = None
