"""The tolerance items of a cube's drawing and how they add up to the tilts of its faces.

Yao 2018 table 2: the cube is machined from its base face C; X is normal to C, Y to the side A, Z to the side B,
each pointing at the opposite face. An item's angle is its tolerance over the cube's side. Yao 2018 table 3: a
face's tilt is the sum of the items on the way to it.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from procedures.arrays import FloatArray

DRAWING_ITEMS: Mapping[str, tuple[str, str, str | None]] = MappingProxyType({  # what of which face, against which
    "t1": ("flatness", "A", None),
    "t2": ("flatness", "B", None),
    "t3": ("flatness", "C", None),
    "t4-1": ("perpendicularity", "C", "A"),
    "t4-2": ("perpendicularity", "C", "B"),
    "t5": ("flatness", "opposite A", None),
    "t6": ("flatness", "opposite B", None),
    "t7": ("flatness", "opposite C", None),
    "t8": ("parallelism", "opposite A", "A"),
    "t9": ("parallelism", "opposite B", "B"),
    "t10": ("parallelism", "opposite C", "C"),
})  # fmt: skip
ITEMS: Mapping[str, str] = MappingProxyType(
    {
        item: f"{kind} of {face}" + (f" to {against}" if against else "")
        for item, (kind, face, against) in DRAWING_ITEMS.items()
    }
)
# Yao 2018 table 3, by `procedures.positions.FACES`; row 4 of the print has wrong indices, it is row 3's face.
_WAYS = (
    ("t3",),
    ("t7", "t3", "t10"),
    ("t1", "t4-1", "t3"),
    ("t5", "t8", "t1", "t4-1", "t3"),
    ("t2", "t4-2", "t3"),
    ("t6", "t9", "t2", "t4-2", "t3"),
)
STACK: FloatArray = np.array([[float(item in way) for item in ITEMS] for way in _WAYS])
"""(6, 11): takes the items' angles to the faces' tilts; rows as `positions.FACES`, columns as `ITEMS`."""
P1_DIRECTION: FloatArray = np.array([[1, 0], [0, 1], [0, 1], [1, 0], [0, 1], [1, 0.0]])
"""(6, 2): the direction in which table 3 lets each face tilt, along the two other cube axes."""


def angles(tolerance_mm: Mapping[str, float], side_mm: float) -> FloatArray:
    """Return the items' angles (11,) [rad] in the order of `ITEMS`.

    Raises
    ------
    ValueError
        An item is missing, unknown or negative, or the side is no length; says what is expected.
    """
    if not (np.isfinite(side_mm) and side_mm > 0):
        raise ValueError(f"side is {side_mm} mm, expected a positive length")
    if wrong := sorted(tolerance_mm.keys() ^ ITEMS.keys()):
        raise ValueError(f"tolerance items {', '.join(wrong)} missing or unknown, expected {', '.join(ITEMS)}")
    for item, size in tolerance_mm.items():
        if not (np.isfinite(size) and size >= 0):
            raise ValueError(f"tolerance {item} is {size} mm, expected zero or more")
    return np.array([tolerance_mm[item] for item in ITEMS]) / side_mm


def p1_tilts(item: FloatArray) -> FloatArray:
    """Return face tilts (6, 2, ...) [rad] of ``item`` (11, ...) [rad], each face in the direction of table 3."""
    tilts: FloatArray = np.einsum("fi,i...,fc->fc...", STACK, item, P1_DIRECTION)
    return tilts
