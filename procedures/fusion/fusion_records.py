"""What a fusion of IMU, GNSS and odometry is given, and a trajectory.

``n`` is East-North-Up, ``b`` the IMU's axes, ``o`` an odometry's own level frame: z up, heading and origin free.
Times [s] are those of one clock. Quaternions are x, y, z, w, and take b to n (b to o).
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray


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
