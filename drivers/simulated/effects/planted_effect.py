"""What a planted effect is, and what the triads feel when it acts.

Shares no code with the effects a diagnosis fits: an error in one cannot hide in the other.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drivers.simulated.truth import Sizes, World
from procedures.arrays import FloatArray

AXES = "xyz"
REFERENCE_C = 25.0  # biases and scale factors of a truth hold at this temperature


@dataclass(frozen=True, slots=True, eq=False)
class Stimulus:
    """What acts on the triads, mean over each sample; rows are samples, or one row that holds for all.

    ``f`` [g], ``omega`` [deg/s] relative to inertial space, ``magnetic`` [uT]: (n or 1, 3), IMU axes. Columns (n,
    1): ``t`` [s] since power-on at mid-interval, ``rest_s`` [s] since the cube was last moved, ``temperature``
    [degC], ``temperature_rate`` [K/min]; ``temperature_at`` gives the temperature at any earlier time (...) [s].
    ``position`` is where the cube is reported to rest, 0 while it moves.
    """

    f: FloatArray
    omega: FloatArray
    magnetic: FloatArray
    t: FloatArray
    rest_s: FloatArray
    temperature: FloatArray
    temperature_rate: FloatArray
    position: int
    temperature_at: Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, slots=True, eq=False)
class TriadInput:
    """A triad's own view: ``raw`` (n or 1, 3) is E u, ``bias`` (3,) is D, in g or deg/s."""

    raw: FloatArray
    bias: FloatArray


Added = Callable[[Stimulus, TriadInput, Sizes], Any]
Changed = Callable[[World, Sizes], World]


@dataclass(frozen=True, slots=True, eq=False)
class PlantedEffect:
    """One effect to plant: ``accel`` and ``gyro`` return what is added to ``E u + D`` [g], [deg/s].

    ``keys`` are the coefficients' names, ``unit`` theirs; ``options`` further settings with their default. Their
    equations stand in `docs/reference/effects.md`, of those with options in `docs/reference/simulated-devices.md`.
    """

    name: str
    unit: str
    keys: tuple[str, ...]
    options: Sizes = field(default_factory=dict)
    accel: Added | None = None
    gyro: Added | None = None
    world: Changed | None = None


def vector(sizes: Sizes, prefix: str = "") -> FloatArray:
    """Return the sizes (3,) of keys x, y, z, in the effect's unit."""
    return np.array([sizes.get(prefix + axis, 0.0) for axis in AXES])


def matrix(sizes: Sizes) -> FloatArray:
    """Return the sizes (3, 3), in the effect's unit, of keys xy: sensor x, input y; x alone stands for xx."""
    full = np.array([[sizes.get(row + column, 0.0) for column in AXES] for row in AXES])
    full[np.diag_indices(3)] += vector(sizes)
    return full


VECTOR_KEYS = tuple(AXES)
MATRIX_KEYS = (*VECTOR_KEYS, *(row + column for row in AXES for column in AXES))
