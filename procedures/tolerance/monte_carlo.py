"""How the errors are distributed over the cubes a drawing brings forth: Monte Carlo through the full formulas.

An item is one number of one cube: its tilt has any sign, uniform between plus and minus its tolerance, or normal
with the tolerance as two standard deviations. A face tilts by the signed sum of the items on the way to it, in
a direction of its own: any, or the one of Yao 2018 table 3.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from procedures.arrays import FloatArray
from procedures.tolerance.drawing_items import P1_DIRECTION, STACK
from procedures.tolerance.estimator_errors import ToleranceUnit, estimator_errors

CUBES_PER_BATCH = 8192  # cubes in one batch: stays in the processor's cache
ToleranceShape = Literal["uniform", "normal"]
Directions = Literal["any", "p1"]
DEVIATION = {"uniform": 1 / np.sqrt(3), "normal": 0.5}  # standard deviation over tolerance


@dataclass(frozen=True, slots=True, eq=False)
class DrawnErrors:
    """Errors of n drawn cubes.

    ``bias`` (3, 3, n) [g]: estimator, sensor. ``scale_factor`` (3, n): relative.
    ``misalignment`` (3, n) [rad]: the angle by which each row of E is off.
    """

    bias: FloatArray
    scale_factor: FloatArray
    misalignment: FloatArray


def draw_tilts(
    rng: np.random.Generator,
    item: FloatArray,
    n: int,
    shape: ToleranceShape = "uniform",
    directions: Directions = "any",
) -> FloatArray:
    """Return the face tilts (6, 2, n) [rad] of n cubes made to the items ``item`` (11,) [rad]."""
    if shape == "uniform":
        part = rng.uniform(-1.0, 1.0, (len(item), n))
    else:
        part = DEVIATION["normal"] * rng.standard_normal((len(item), n))
    size: FloatArray = STACK @ (item[:, None] * part)
    if directions == "p1":
        return size[:, None] * P1_DIRECTION[..., None]
    azimuth = rng.uniform(0.0, 2 * np.pi, (6, n))
    return np.stack((size * np.cos(azimuth), size * np.sin(azimuth)), axis=1)


def tilt_std(item: FloatArray, shape: ToleranceShape = "uniform") -> FloatArray:
    """Return 1 sigma (6,) [rad] of a face's two tilts by ``item`` (11,) [rad], directions being any."""
    size: FloatArray = np.sqrt(STACK @ item**2 / 2) * DEVIATION[shape]
    return size


def draw_errors(
    item: FloatArray,
    unit: ToleranceUnit,
    n: int,
    seed: int,
    shape: ToleranceShape = "uniform",
    directions: Directions = "any",
) -> DrawnErrors:
    """Draw n cubes made to ``item`` (11,) [rad], return the errors on each; equal seeds give equal cubes."""
    rng = np.random.default_rng(seed)
    bias, scale, angle = np.empty((3, 3, n)), np.empty((3, n)), np.empty((3, n))
    for begin in range(0, n, CUBES_PER_BATCH):
        part = slice(begin, min(begin + CUBES_PER_BATCH, n))
        found = estimator_errors(draw_tilts(rng, item, part.stop - begin, shape, directions), unit)
        bias[..., part], scale[:, part] = found.bias, found.scale_factor
        angle[:, part] = np.sqrt(np.sum(found.misalignment**2, axis=1))
    return DrawnErrors(bias, scale, angle)
