"""Records of the fusion: IMU samples, GNSS fixes, wheel speeds, an alignment and a trajectory.

``n`` is East-North-Up, ``b`` the IMU's axes, ``o`` an odometry's own level frame: z up, heading and origin free.
Times [s] are those of one clock. Quaternions are x, y, z, w, and take b to n (b to o).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.geodesy import LocalLevel
from procedures.gnss_records import UNSTATED_STD_M, FixType, GnssFix


@dataclass(frozen=True, slots=True, eq=False)
class ImuSeries:
    """Calibrated IMU samples: ``t`` (n,) [s], ``omega_b`` (n, 3) [rad/s], ``f_b`` (n, 3) [m/s2]."""

    t: FloatArray
    omega_b: FloatArray
    f_b: FloatArray


@dataclass(frozen=True, slots=True)
class ImuNoise:
    """Densities of white noise and of the biases' random walks, and what is known of the biases at the start.

    ``gyro`` [rad/s/sqrt(Hz)], ``gyro_walk`` [rad/s2/sqrt(Hz)], ``accel`` [m/s2/sqrt(Hz)], ``accel_walk``
    [m/s3/sqrt(Hz)]; ``gyro_bias`` [rad/s] and ``accel_bias`` [m/s2] are 1 sigma about zero.
    """

    gyro: float
    gyro_walk: float
    accel: float
    accel_walk: float
    gyro_bias: float = 0.1
    accel_bias: float = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class GnssFixes:
    """GNSS fixes: what is not known is nan.

    ``t`` (n,) [s]; ``p_n`` (n, 3) [m] of the antenna; ``v_n`` (n, 3) [m/s], up may be missing alone;
    ``course`` (n,) [rad] from North towards East, for receivers that give it without a velocity;
    ``position_std`` (n,) [m] and ``velocity_std`` (n,) [m/s] are 1 sigma of each axis.
    """

    t: FloatArray
    p_n: FloatArray
    v_n: FloatArray
    course: FloatArray
    position_std: FloatArray
    velocity_std: FloatArray

    def __post_init__(self) -> None:
        n = len(self.t)
        shapes = {"p_n": (n, 3), "v_n": (n, 3), "course": (n,), "position_std": (n,), "velocity_std": (n,)}
        for name, shape in shapes.items():
            if (got := getattr(self, name).shape) != shape:
                raise ValueError(f"GnssFixes.{name} has shape {got}, expected {shape}")

    @property
    def has_velocity(self) -> BoolArray:
        """Which fixes (n,) have a velocity, level at least: true or false."""
        return np.asarray(np.isfinite(self.v_n[:, :2]).all(axis=1))

    def part(self, which: slice | BoolArray) -> "GnssFixes":
        """Return some of the fixes: a slice, or those ``which`` (n,) says."""
        return GnssFixes(*(getattr(self, field.name)[which] for field in fields(self)))

    def followed_by(self, more: "GnssFixes") -> "GnssFixes":
        """Return the fixes with later ones after them."""
        names = [field.name for field in fields(self)]
        return GnssFixes(*(np.concatenate((getattr(self, name), getattr(more, name))) for name in names))

    def shifted(self, offset: float) -> "GnssFixes":
        """Return the fixes with ``offset`` [s] added to their time stamps."""
        return replace(self, t=self.t + offset)


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses: ``t`` (n,) [s] increasing, ``p`` (n, 3) [m], unit quaternions ``q`` (n, 4)."""

    t: FloatArray
    p: FloatArray
    q: FloatArray

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True, slots=True, eq=False)
class WheelMount:
    """``forward`` (3,), a unit vector in b; ``lever`` (3,) [m] in b from IMU to wheel or middle of the axle.

    ``std`` [m/s] is 1 sigma of a speed, ``scale_std`` that of the scale factor about 1, by which a speed is to be
    multiplied. ``is_signed``: the sensor reports backwards by a minus; else its speeds have no sign.
    """

    forward: FloatArray
    lever: FloatArray
    std: float
    scale_std: float
    is_signed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class WheelSpeeds:
    """``t`` (n,) [s], increasing, by the IMU's clock; ``speed`` (n,) [m/s] as the sensor reports it."""

    t: FloatArray
    speed: FloatArray

    def followed_by(self, more: "WheelSpeeds") -> "WheelSpeeds":
        """Return the speeds with later ones after them."""
        return WheelSpeeds(np.r_[self.t, more.t], np.r_[self.speed, more.speed])

    def since(self, t: float) -> "WheelSpeeds":
        """Return those after ``t`` [s]."""
        later = self.t > t
        return WheelSpeeds(self.t[later], self.speed[later])


@dataclass(frozen=True, slots=True, eq=False)
class KeyframeWheel:
    """What a wheel says at a keyframe: ``along`` (3,) is forward in b, ``due`` and ``speed`` [m/s].

    ``weight`` is the inverse variance [s2/m2] of the speed, ``rest_weight`` that of each axis of a rest; 0 where
    nothing is measured.
    """

    along: FloatArray
    due: float
    speed: float
    weight: float
    rest_weight: float = 0.0


def no_speeds() -> WheelSpeeds:
    """Return none."""
    return WheelSpeeds(np.zeros(0), np.zeros(0))


UP_TO_LEVEL = 1.5  # of the sigma of height to that of place, where a receiver states one only
UNSTATED_SPEED_STD = 0.2  # m/s of each axis
SOURCES = ("GPS_RAW_INT", "GPS_INPUT", "GPS2_RAW")  # of several the first: another antenna stands elsewhere


def is_usable(fix: GnssFix) -> bool:
    """Whether a fix has a place in three dimensions that no filter of its sender has had a hand in."""
    return fix.has_position and fix.fix >= FixType.FIX_3D and not fix.is_filtered and _height(fix) is not None


def antenna(fixes: Sequence[GnssFix]) -> str:
    """Return the message whose fixes are to be used, empty where there is none."""
    seen = {fix.source for fix in fixes if is_usable(fix)}
    return next((source for source in SOURCES if source in seen), "")


def origin_at(fix: GnssFix) -> LocalLevel:
    """Return the level frame about a usable fix."""
    assert fix.latitude is not None
    assert fix.longitude is not None
    return LocalLevel(fix.latitude, fix.longitude, _height(fix) or 0.0)


def level_fixes(origin: LocalLevel, t: FloatArray, fixes: Sequence[GnssFix]) -> GnssFixes:
    """Return usable fixes, valid at times ``t`` (n,) [s] of the IMU's clock, in a level frame."""
    n = len(fixes)
    p_n, v_n = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    for i, fix in enumerate(fixes):
        assert fix.latitude is not None
        assert fix.longitude is not None
        p_n[i] = origin.enu(fix.latitude, fix.longitude, _height(fix) or 0.0)
        if (level := fix.velocity_n) is not None:
            v_n[i] = *level, np.nan if fix.v_up is None else fix.v_up
    std = np.array([_position_std(fix) for fix in fixes], dtype=np.float64)
    speed_std = np.array([fix.speed_std or UNSTATED_SPEED_STD for fix in fixes], dtype=np.float64)
    return GnssFixes(t, p_n, v_n, np.full(n, np.nan), std, speed_std)


def _height(fix: GnssFix) -> float | None:
    return fix.altitude if fix.height is None else fix.height


def _position_std(fix: GnssFix) -> float:
    level = fix.horizontal_std or UNSTATED_STD_M
    up = fix.vertical_std or UP_TO_LEVEL * level
    return float(np.sqrt((2 * level**2 + up**2) / 3))


MAX_YAW_STD = np.radians(4.0)  # 1 sigma with which an alignment is accepted
MAX_TILT_STD = np.radians(1.0)
MAX_TIME_OFFSET_STD_S = 0.015  # s, of GNSS's stamps where it is estimated: a window is built on it


def in_degrees(*std: float) -> FloatArray:
    """Return 1 sigma (n,) of angles, given in rad, in degrees for a sentence: half a turn at most."""
    return np.degrees(np.minimum(std, np.pi))


@dataclass(frozen=True, slots=True, eq=False)
class AlignmentState:
    """State at the first of the fixes ``t0``: ``C_nb``, ``v_n``, biases and constants with covariance.

    In the order rotation about n [rad], v [m/s], gyro bias [rad/s], accelerometer bias [m/s2]: (12, 12). In motion
    ``lever`` (3,) [m] in b, the antenna's, and ``time_offset`` [s], to be added to the stamps of fixes, follow:
    (16, 16), 0 where they were given; ``t0`` and ``t`` hold that offset. ``C_now`` is the attitude at the
    last fix, ``tilt_std`` and ``yaw_std`` [rad] 1 sigma of it.
    """

    t0: float
    C_nb: FloatArray
    v_n: FloatArray
    gyro_bias: FloatArray
    accel_bias: FloatArray
    covariance: FloatArray
    t: float
    C_now: FloatArray
    tilt_std: float
    yaw_std: float
    misfit: float
    lever: FloatArray | None = None
    time_offset: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Waiting:
    """Why there is no alignment yet."""

    why: str
