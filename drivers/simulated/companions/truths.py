"""True parameters of a simulated camera and of a simulated autopilot; the track has where they are."""

from dataclasses import dataclass, field

import numpy as np

from drivers.errors import TruthRefused
from procedures.arrays import FloatArray

# x right, y down, z along the view: to the left of the vehicle and 35 deg ahead, level
OBLIQUE = np.array([
    [np.sin(np.radians(55)), 0.0, np.cos(np.radians(55))],
    [-np.cos(np.radians(55)), 0.0, np.sin(np.radians(55))],
    [0.0, -1.0, 0.0],
])  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CameraTruth:
    """A pinhole camera, integer pixels at their middles as OpenCV has them, fixed to the IMU.

    ``C_bc`` (3, 3) takes camera to IMU axes, ``t_bc`` (3,) [m] is the camera in the IMU's axes. ``latency_s``
    passes from taking an image to sending it. The camera's own clock says ``clock_offset_s`` at true time 0 and is
    ``clock_ppm`` fast. ``noise`` is 1 sigma of a pixel's grey.
    """

    width: int = 376
    height: int = 240
    fx: float = 230.0
    fy: float = 230.0
    cx: float = 187.5
    cy: float = 119.5
    rate_hz: float = 15.0
    C_bc: FloatArray = field(default_factory=OBLIQUE.copy)
    t_bc: FloatArray = field(default_factory=lambda: np.array([0.3, 0.2, 0.1]))
    latency_s: float = 0.04
    clock_offset_s: float = 1000.0
    clock_ppm: float = 20.0
    quality: int = 90
    noise: float = 1.5

    def __post_init__(self) -> None:
        if self.C_bc.shape != (3, 3) or np.abs(self.C_bc @ self.C_bc.T - np.eye(3)).max() > 1e-6:
            raise TruthRefused(f"C_bc {self.C_bc.tolist()}", "a rotation matrix, camera to IMU axes")
        if self.t_bc.shape != (3,):
            raise TruthRefused(f"t_bc {self.t_bc.tolist()}", "three numbers [m]")

    @property
    def K(self) -> FloatArray:
        """The intrinsics as a matrix (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def stamp(self, t: float) -> float:
        """Return the camera's own time [s] at true time ``t`` [s]."""
        return self.clock_offset_s + t * (1 + 1e-6 * self.clock_ppm)


def camera_toml(camera: CameraTruth, url: str) -> str:
    """Return the description of the camera, ``camera/1``, as it truly is and served at ``url``."""
    imu_from_camera = np.eye(4)
    imu_from_camera[:3, :3], imu_from_camera[:3, 3] = camera.C_bc, camera.t_bc
    rows = ",\n".join(f"  [{', '.join(f'{float(value)!r}' for value in row)}]" for row in imu_from_camera)
    return f"""format = "camera/1"
url = "{url}"
std_px = 1.0
fx_px = {float(camera.fx)!r}
fy_px = {float(camera.fy)!r}
cx_px = {float(camera.cx)!r}
cy_px = {float(camera.cy)!r}
distortion = [0.0, 0.0, 0.0, 0.0]
imu_from_camera = [
{rows},
]
"""


EPOCH_UTC = 1_780_000_000.0  # s since 1970 at time 0


@dataclass(frozen=True, slots=True, kw_only=True)
class AutopilotTruth:
    """How it answers and what it sends.

    ``default_hz`` what it sends unasked; ``most_hz`` above which an interval is DENIED, as are those of
    ``denies``; without ``knows_intervals`` SET_MESSAGE_INTERVAL is UNSUPPORTED; unless it ``obeys``, what is asked
    for is accepted and nothing comes of it. ``states_utc``: GPS_RAW_INT is
    stamped with UTC, else with the time since boot; ``states_accuracy``: its extension fields are filled;
    ``states_velocity``: speed and course are.
    """

    system: int = 1
    component: int = 1
    epoch_utc: float = EPOCH_UTC
    default_hz: float = 1.0
    most_hz: float = 50.0
    denies: frozenset[int] = frozenset()
    knows_intervals: bool = True
    obeys: bool = True
    states_utc: bool = False
    states_accuracy: bool = True
    states_velocity: bool = True
    latency_s: float = 0.1
    position_std_m: float = 1.0
    velocity_std_m_s: float = 0.05
    undulation_m: float = 12.0
    temperature_c: float = 41.0
    airspeed_m_s: float = 0.0
    key: bytes = b""
    wrong_key: bytes = field(default=bytes(range(32)), repr=False)
