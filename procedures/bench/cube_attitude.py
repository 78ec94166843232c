"""The attitude of a cube that is carried, from gyro angles and from gravity, with the sigma of its heading.

A small angle theta (3,) in cube axes makes ``C_lb`` (cube to slab) ``C_lb exp([theta x])``. Gravity determines
the two tilts; the heading is known from its last fix alone, infinite without one:

    std^2 = fix^2 + (k_std turned)^2 + (GYRO_MISALIGNMENT_RAD path)^2 + gap^2

with ``turned`` the angle about the vertical, ``path`` that about level axes, ``gap`` what a gap may hide.
"""

from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import rotation, vertical_rotation
from procedures.free_positions.free_attitudes import C_bn_of_up
from procedures.positions import face_normal, face_of, nominal_C_lb

GYRO_MISALIGNMENT_RAD = 0.01  # rad: gyros are 0.1 deg to 1 deg off square
HAND_RATE_RAD_S = np.pi / 2  # rad/s: as fast as hands turn a cube that nobody watches
MAX_HEADING_SIGMAS = 4.0  # sigma


@dataclass(frozen=True, slots=True, eq=False)
class CubeAttitude:
    """``C_lb`` (3, 3); ``heading_fix_std`` [rad] of the heading's last fix, infinite without one.

    ``turned`` and ``path`` [rad] since then.
    """

    C_lb: FloatArray
    heading_fix_std: float = np.inf
    turned: float = 0.0
    path: float = 0.0

    @property
    def up(self) -> FloatArray:
        """The unit vector (3,), cube axes, that points up."""
        up: FloatArray = self.C_lb[2]
        return up

    def heading_std(self, k_std: float) -> float:
        """Return 1 sigma of the heading [rad]; ``k_std`` is that of the gyros' scale factor, relative."""
        parts = np.array([self.heading_fix_std, k_std * self.turned, GYRO_MISALIGNMENT_RAD * self.path])
        return float(np.sqrt(parts @ parts)) if np.isfinite(parts).all() else np.inf


def attitude_of_up(up: FloatArray) -> CubeAttitude:
    """Return a cube of which no more is known than which way ``up`` (3,), cube axes, is up."""
    return CubeAttitude(C_bn_of_up(up).T)


def propagated(before: CubeAttitude, angles: FloatArray) -> CubeAttitude:
    """Return the cube after the small rotations ``angles`` (n, 3) [rad], cube axes, one after the other."""
    C, turned, path = before.C_lb, before.turned, before.path
    for angle, step in zip(angles, rotation(angles), strict=True):
        vertical = float(C[2] @ angle)
        turned += vertical
        path += float(np.sqrt(max(angle @ angle - vertical**2, 0.0)))
        C = C @ step
    return replace(before, C_lb=C, turned=turned, path=path)


def tilt_corrected(before: CubeAttitude, up: FloatArray, gain: float) -> CubeAttitude:
    """Return the cube tilted by ``gain`` of the way to where ``up`` (3,), a unit vector in cube axes, is up."""
    seen = before.C_lb @ up
    axis = np.array([seen[1], -seen[0], 0.0])  # seen x vertical: level
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:  # upright, or upside down: which way over, nothing says
        return before if seen[2] > 0 else replace(attitude_of_up(up), path=before.path)
    angle = float(np.arctan2(sine, seen[2]))
    return replace(before, C_lb=_square(rotation(axis / sine * angle * gain) @ before.C_lb))


def after_gap(before: CubeAttitude, seconds: float, k_std: float) -> CubeAttitude:
    """Return the cube after a gap in the data: hands turn it by `HAND_RATE_RAD_S` at most."""
    return replace(
        before,
        heading_fix_std=float(np.hypot(before.heading_std(k_std), HAND_RATE_RAD_S * seconds)),
        turned=0,
        path=0,
    )


def without_heading(before: CubeAttitude) -> CubeAttitude:
    """Return the cube with its heading unknown."""
    return replace(before, heading_fix_std=np.inf, turned=0.0, path=0.0)


def heading_corrected(before: CubeAttitude, off: float, std: float, k_std: float) -> CubeAttitude:
    """Return the cube once its heading is fixed: ``off`` [rad], 1 sigma ``std``, farther counter-clockwise.

    The mean by both sigmas; where they contradict each other the fix counts, as it does not drift.
    """
    known = before.heading_std(k_std)
    if not np.isfinite(std):
        return before
    agrees = abs(off) <= MAX_HEADING_SIGMAS * np.hypot(known, std)
    share = known**2 / (known**2 + std**2) if agrees and np.isfinite(known) else 1.0
    C = vertical_rotation(share * off) @ before.C_lb
    return CubeAttitude(C, float(np.sqrt(share)) * std)


def heading_to_position(now: CubeAttitude, position: int) -> float:
    """Return how far to turn the cube [rad], counter-clockwise seen from above, to stand as in ``position``.

    Between -pi and pi; it must rest on the face of that position, near enough.
    """
    up = face_normal(face_of(position))
    C = tilt_corrected(now, up, 1.0).C_lb
    turn = nominal_C_lb(position) @ C.T  # about the vertical
    return float(np.arctan2(turn[1, 0], turn[0, 0]))


def _square(C: FloatArray) -> FloatArray:
    """Return the rotation nearest to ``C``: rounding adds up over hours."""
    left, _, right = np.linalg.svd(C)
    squared: FloatArray = left @ right
    return squared
