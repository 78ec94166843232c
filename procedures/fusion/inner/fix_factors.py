"""What a fix says in the inner window: factors of gtsam on pose (C, p), velocity v and, where they are estimated,
a state of constants: the antenna's lever arm l (3) [m] in b, and the offset tau [s] that GNSS's stamps lack.

    velocity   v + C (omega x l) + a tau - z_v
    position   p + C l + v tau - z_p

Within tau the motion is straight. gtsam has the second without tau (`GPSFactorArmCalib`) and the first not at all;
in Python a factor costs some 20 us, so that what is given goes by gtsam's own.
"""  # noqa: D205

from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import skew


@dataclass(frozen=True, slots=True, eq=False)
class FixFactors:
    """A fix's velocity ``v`` (3,) [m/s] and position ``p`` (3,) [m] in n, or None, and 1 sigma of each axis."""

    v: FloatArray | None
    v_std: FloatArray
    p: FloatArray | None
    p_std: FloatArray

    def as_given(self, lib: Any, keys: list[int], swing: FloatArray, lever: FloatArray) -> list[Any]:
        """Return the factors on pose and velocity; the antenna moves by ``swing`` (3,) [m/s] about the IMU."""
        sigmas, made = lib.noiseModel.Diagonal.Sigmas, []
        if self.v is not None:
            made.append(lib.PriorFactorVector(keys[1], self.v - swing, sigmas(self.v_std)))
        if self.p is not None:
            made.append(lib.GPSFactorArm(keys[0], self.p, lever, sigmas(self.p_std)))
        return made

    def with_constants(self, lib: Any, keys: list[int], omega_b: FloatArray, a_n: FloatArray) -> list[Any]:
        """Return the factors on pose, velocity and constants, turning at ``omega_b`` [rad/s], ``a_n`` [m/s2]."""
        sigmas, made = lib.noiseModel.Diagonal.Sigmas, []
        if self.v is not None:
            made.append(lib.CustomFactor(sigmas(self.v_std), keys, _velocity(self.v, omega_b, a_n)))
        if self.p is not None:
            made.append(lib.CustomFactor(sigmas(self.p_std), keys, _position(self.p)))
        return made


def _velocity(z: FloatArray, omega_b: FloatArray, a_n: FloatArray) -> Any:
    def error(this: Any, values: Any, J: list[FloatArray] | None) -> FloatArray:
        C, _, v, c = _states(this, values)
        swing = np.cross(omega_b, c[:3])
        if J is not None:
            J[0] = np.hstack((-C @ skew(swing), np.zeros((3, 3))))
            J[1] = np.eye(3)
            J[2] = np.column_stack((C @ skew(omega_b), a_n))
        off: FloatArray = v + C @ swing + a_n * c[3] - z
        return off

    return error


def _position(z: FloatArray) -> Any:
    def error(this: Any, values: Any, J: list[FloatArray] | None) -> FloatArray:
        C, p, v, c = _states(this, values)
        if J is not None:
            J[0] = np.hstack((-C @ skew(c[:3]), C))
            J[1] = np.eye(3) * c[3]
            J[2] = np.column_stack((C, v))
        off: FloatArray = p + C @ c[:3] + v * c[3] - z
        return off

    return error


def _states(factor: Any, values: Any) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    at = factor.keys()
    pose = values.atPose3(at[0])
    C, p = np.asarray(pose.rotation().matrix()), np.asarray(pose.translation())
    return C, p, np.asarray(values.atVector(at[1])), np.asarray(values.atVector(at[2]))
