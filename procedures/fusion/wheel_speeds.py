"""What a wheel says of how fast a vehicle goes, and how the wheel stands to the IMU."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class WheelMount:
    """``forward`` (3,), a unit vector in b; ``lever`` (3,) [m] in b from IMU to wheel or middle of the axle.

    ``std`` [m/s] is 1 sigma of a speed, ``scale_std`` that of the scale factor about 1, by which a speed is to be
    multiplied. ``is_signed``: the sensor tells backwards by a minus; else its speeds have no sign.
    """

    forward: FloatArray
    lever: FloatArray
    std: float
    scale_std: float
    is_signed: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class WheelSpeeds:
    """``t`` (n,) [s], increasing, by the IMU's clock; ``speed`` (n,) [m/s] as the sensor tells it."""

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
    nothing is said.
    """

    along: FloatArray
    due: float
    speed: float
    weight: float
    rest_weight: float = 0.0


def no_speeds() -> WheelSpeeds:
    """Return none."""
    return WheelSpeeds(np.zeros(0), np.zeros(0))
