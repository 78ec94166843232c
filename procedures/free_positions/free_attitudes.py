"""Free attitudes: which way of the cube points up between its faces, how far two ways are apart, which is wanted.

The ways wanted are the middles of the cube's twelve edges (45 deg from two faces) and its eight corners (54.7 deg
from three): any two are at least 35 deg apart, and one nearest to none that was taken is wanted next.
"""

from collections.abc import Iterable
from itertools import product

import numpy as np

from procedures.arrays import FloatArray

UpDirection = tuple[int, int, int]  # the way up in cube axes: -1, 0 or 1 each

MIN_APART_DEG = 20.0  # from every face, and from every attitude taken
_DIRECTIONS: list[UpDirection] = [
    (x, y, z) for x, y, z in product((1, 0, -1), repeat=3) if abs(x) + abs(y) + abs(z) > 1
]
# The 12 edges, then the 8 corners
UP_DIRECTIONS: tuple[UpDirection, ...] = tuple(sorted(_DIRECTIONS, key=np.count_nonzero))


def up_vector(tilt: UpDirection) -> FloatArray:
    """Return the unit vector (3,), cube axes, that points up."""
    up: FloatArray = np.array(tilt) / np.linalg.norm(tilt)
    return up


def angle_deg(one: FloatArray, other: FloatArray) -> float:
    """Return the angle [deg] between two directions ``one`` and ``other`` (3,), of any length."""
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)))


def nearest_deg(up: FloatArray, taken: Iterable[FloatArray]) -> float:
    """Return how far ``up`` (3,) is from the nearest of those taken [deg]; 180 if there are none."""
    return min((angle_deg(up, other) for other in taken), default=180.0)


def next_direction(taken: Iterable[FloatArray]) -> UpDirection:
    """Return the direction that is wanted up next, after those ``taken`` (3,).

    An edge, then a corner; the farthest from all once they were taken.
    """
    ups = list(taken)
    free = (tilt for tilt in UP_DIRECTIONS if nearest_deg(up_vector(tilt), ups) > MIN_APART_DEG + 5)
    return next(free, max(UP_DIRECTIONS, key=lambda tilt: nearest_deg(up_vector(tilt), ups)))


def C_bn_of_up(up: FloatArray, heading: float = 0.0) -> FloatArray:
    """Return ``C_bn`` (3, 3), East-North-Up to the cube, with ``up`` (3,) up, turned by ``heading`` [rad]."""
    up = up / np.linalg.norm(up)
    level = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], up)
    level /= np.linalg.norm(level)
    east = np.cos(heading) * level + np.sin(heading) * np.cross(up, level)
    return np.column_stack((east, np.cross(up, east), up))
