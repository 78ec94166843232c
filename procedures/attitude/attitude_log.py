"""Input of the attitude filters: samples of an `attitude-log/1`, and the frames of roll and pitch.

Body axes are forward-right-down, the level frame is north-east-down, as in You and Lee and in MAVLink; the rest of
the station works in East-North-Up (`procedures.frames`). At rest and level the specific force is (0, 0, -g).
``C_nb`` takes forward-right-down to north-east-down; its last row is the down vector.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.counts.sample_times import GAP_PERIODS
from procedures.geodesy import earth_rate_n

ENU_NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # its own inverse


def down_of(roll: FloatArray, pitch: FloatArray) -> FloatArray:
    """Return the down vector (..., 3) in body axes of roll and pitch [rad]."""
    level = np.cos(pitch)
    return np.stack([-np.sin(pitch), np.sin(roll) * level, np.cos(roll) * level], axis=-1)


def roll_pitch_of(down: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return roll and pitch [rad] of down vectors (..., 3); at pitch 90 deg roll is arbitrary."""
    x, y, z = down[..., 0], down[..., 1], down[..., 2]
    return np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))


def inclination(down: FloatArray, other: FloatArray) -> FloatArray:
    """Return the angle [rad] between ``down`` and ``other`` (..., 3): the error of roll and pitch together."""
    angle: FloatArray = np.arctan2(np.linalg.norm(np.cross(down, other), axis=-1), np.sum(down * other, axis=-1))
    return angle


def earth_rate_ned(latitude: float) -> FloatArray:
    """Return the Earth's rotation rate (3,) [rad/s] in north-east-down at a latitude [rad]."""
    return ENU_NED @ earth_rate_n(latitude)


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeLog:
    """Consecutive samples; means over the interval that ends at ``t``.

    ``t`` (n,) [s], increasing; ``omega_b`` (n, 3) [rad/s], angular rate; ``f_b`` (n, 3) [m/s2], specific force.
    Aids are None where there is none, nan where there is no value at a row: ``airspeed`` (n,) [m/s] along body x,
    ``velocity`` (n, 3) [m/s] north-east-down, ``heading`` (n,) [rad] true. Truth: ``roll``, ``pitch`` (n,) [rad],
    ``scored`` (n,).
    """

    t: FloatArray
    omega_b: FloatArray
    f_b: FloatArray
    airspeed: FloatArray | None = None
    velocity: FloatArray | None = None
    heading: FloatArray | None = None
    roll: FloatArray | None = None
    pitch: FloatArray | None = None
    scored: BoolArray | None = None

    def __post_init__(self) -> None:
        n = len(self.t)
        shapes = {"omega_b": (n, 3), "f_b": (n, 3), "velocity": (n, 3)}
        for name in ("omega_b", "f_b", "airspeed", "velocity", "heading", "roll", "pitch", "scored"):
            value, expected = getattr(self, name), shapes.get(name, (n,))
            if value is not None and value.shape != expected:
                raise ValueError(f"AttitudeLog.{name} has shape {value.shape}, expected {expected}")

    @property
    def nominal(self) -> float:
        """The usual interval [s]."""
        return float(np.median(np.diff(self.t))) if len(self.t) > 1 else 0.01

    @property
    def intervals(self) -> FloatArray:
        """The time (n,) [s] since the row before; the first row's is the usual one."""
        return np.diff(self.t, prepend=self.t[0] - self.nominal)

    @property
    def gaps(self) -> list[tuple[float, float]]:
        """Start and end [s] of every step of time above 1.5 nominal intervals."""
        after = np.flatnonzero(np.diff(self.t) > GAP_PERIODS * self.nominal)
        return [(float(self.t[i]), float(self.t[i + 1])) for i in after]

    @property
    def true_down(self) -> FloatArray | None:
        """The true down vector (n, 3), nan where not known; None without truth."""
        return None if self.roll is None or self.pitch is None else down_of(self.roll, self.pitch)
