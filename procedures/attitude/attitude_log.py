"""What the attitude algorithms take: samples of an `attitude-log/1`, forward-right-down."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.attitude.forward_right_down import down_of
from procedures.counts.sample_times import GAP_PERIODS


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
