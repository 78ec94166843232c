"""Effects that Yao 2018 neglects, one by one: seating, plate, model terms, rotations.

Each is an item with a tolerance t; the item is uniform within plus and minus t, and what it does is given as 1
sigma by the first order that does not vanish. Slopes and seat tilts have any direction, so that each of their two
components has the variance t^2 / 6. Positions and formulas are the paper's (3)-(11); gyroscopes are taken as
aligned.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import AXES
from procedures.geodesy import EARTH_RATE
from procedures.tolerance.estimator_errors import tilt_std
from procedures.units import PPM_PER_ONE, RAD_S_PER_DEG_H, UG_PER_G

REVOLUTIONS = 3  # of a turn, Yao 2018, section 2
UNIFORM = 1 / np.sqrt(3)  # standard deviation over tolerance
QUANTITIES: Mapping[str, str] = MappingProxyType({
    "accelerometer.bias_12_position": "g",
    "accelerometer.bias_two_direction": "g",
    "accelerometer.bias": "g",  # of the joint solve
    "accelerometer.scale_factor": "1",
    "accelerometer.misalignment": "rad",  # by which a row of E is off
    "gyroscope.bias": "rad/s",
    "gyroscope.scale_factor": "1",
    "gyroscope.misalignment": "rad",
})  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class SetAsideCase:
    """The campaign that the items act in.

    ``E`` (3, 3) of the accelerometers, rows of unit length; sides of the cube and of the IMU's seat [mm]; latitude
    [rad]; seconds that a turn takes; ``item`` (11,) [rad], the drawing's own.
    """

    E: FloatArray
    side_mm: float
    seat_side_mm: float
    latitude: float
    turn_s: float
    item: FloatArray


Acts = Callable[[float, SetAsideCase], dict[str, FloatArray]]


@dataclass(frozen=True, slots=True)
class SetAsideItem:
    """``size`` is what is usual, in ``unit``; ``acts`` takes a size to 1 sigma (3,) of each of `QUANTITIES`."""

    what: str
    unit: str
    size: float
    source: str
    acts: Acts


def _slab_flatness(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # every placement has a slope of its own, size over the cube's side; a constant tilt is the level's
    s, square = size / case.side_mm / np.sqrt(6), case.E**2
    along = np.sum(square * (1 - square), axis=1)
    earth = EARTH_RATE * np.sqrt(4 * np.cos(case.latitude) ** 2 + 8 * np.sin(case.latitude) ** 2) / 12
    return {
        "accelerometer.bias_12_position": np.full(3, s * np.sqrt(8) / 12),
        "accelerometer.bias_two_direction": s * np.sqrt(1 - np.diag(square)) / 2,
        "accelerometer.scale_factor": s * np.sqrt(along) / 2,
        "accelerometer.misalignment": s * np.sqrt(2 - along) / 2,
        "gyroscope.bias": np.full(3, s * earth),
    }


def _slab_level(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # a tilt of the whole slab cancels in every pair; of the up vector's part along the axis 1 - tilt^2 / 2 is left
    return {"accelerometer.scale_factor": np.full(3, (size / 1000) ** 2 / np.sqrt(20))}


def _seat_base(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # the seat is parallel to C: it tilts the IMU about y and z
    return _seat(case, np.array([0, 1, 1]) * (size / case.seat_side_mm) ** 2 / 6)


def _seat_stop(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # the stop is parallel to A: it turns the IMU about x
    return _seat(case, np.array([1, 0, 0]) * (size / case.seat_side_mm) ** 2 / 3)


def _seat(case: SetAsideCase, variance: FloatArray) -> dict[str, FloatArray]:
    # row q of E is off by E_q x psi, psi the seat's rotation of ``variance`` (3,); biases and k are not
    return {
        "accelerometer.misalignment": np.sqrt((1 - case.E**2) @ variance),
        "gyroscope.misalignment": np.sqrt((1 - np.eye(3)) @ variance),
    }


def _quadratic(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    K2 = UNIFORM * size / UG_PER_G
    return {
        "accelerometer.bias_12_position": np.full(3, K2 / 3),
        "accelerometer.bias_two_direction": K2 * np.diag(case.E) ** 2,
        "accelerometer.bias": np.full(3, K2),
    }


def _asymmetry(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # a turn and its counter-turn cancel |rate|; the Earth's, up or North in 8 of 12 positions, stays
    mean = EARTH_RATE * (np.abs(np.sin(case.latitude)) + np.abs(np.cos(case.latitude))) / 3
    return {"gyroscope.bias": np.full(3, UNIFORM * size / PPM_PER_ONE * mean)}


def _nonlinearity(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    return {"gyroscope.scale_factor": np.full(3, UNIFORM * size / PPM_PER_ONE)}


def _accelerometer_instability(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    s = np.full(3, UNIFORM * size / UG_PER_G)
    return {
        "accelerometer.bias_12_position": s / np.sqrt(12),
        "accelerometer.bias_two_direction": s / 2,
        "accelerometer.bias": s / 2,
        "accelerometer.scale_factor": s / 2,
        "accelerometer.misalignment": s / np.sqrt(2),
    }


def _gyroscope_instability(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    s = np.full(3, UNIFORM * size * RAD_S_PER_DEG_H)
    turned = s * case.turn_s / (np.sqrt(2) * 2 * np.pi * REVOLUTIONS)
    return {
        "gyroscope.bias": s / np.sqrt(12),
        "gyroscope.scale_factor": turned,
        "gyroscope.misalignment": np.sqrt(2) * turned,
    }


def _faces_in_turns(size: float, case: SetAsideCase) -> dict[str, FloatArray]:
    # the turn about p is one about the up vector of p's lower face: column p of E is off by its tilt
    variance = (size * tilt_std(case.item)) ** 2
    up, both = variance[::2], variance[::2] + variance[1::2]
    vertical = EARTH_RATE * np.abs(np.sin(case.latitude))
    return {
        "gyroscope.bias": vertical * np.sqrt(both.sum() - both) / 6,
        "gyroscope.misalignment": np.sqrt(up.sum() - up),
    }


_GYRO = "IEEE 952; Yao 2018 (1)"
SET_ASIDE: Mapping[str, SetAsideItem] = MappingProxyType({
    "slab-flatness": SetAsideItem("flatness of the plate", "mm", 0.008, "DIN 876, grade 0, 1 m", _slab_flatness),
    "slab-level": SetAsideItem("level of the plate", "mm/m", 0.1, "a machinist's level", _slab_level),
    "seat-base-flatness": SetAsideItem("flatness of the seat", "mm", 0.01, "Yao 2018, 3", _seat_base),
    "seat-base-parallelism": SetAsideItem("parallelism of the seat to C", "mm", 0.02, "Yao 2018, 3", _seat_base),
    "seat-stop-flatness": SetAsideItem("flatness of the seat's stop", "mm", 0.01, "Yao 2018, 3", _seat_stop),
    "seat-stop-parallelism": SetAsideItem("parallelism of the stop to A", "mm", 0.02, "Yao 2018, 3", _seat_stop),
    "quadratic": SetAsideItem("K2 of the accelerometers", "ug/g2", 10.0, "IEEE 1293; Yao 2018 (2)", _quadratic),
    "accelerometer-wander": SetAsideItem("accelerometer bias, step to step", "ug", 1.0,
                                         "IEEE 1293, bias repeatability", _accelerometer_instability),
    "gyroscope-wander": SetAsideItem("gyroscope bias, step to step", "deg/h", 0.01, _GYRO, _gyroscope_instability),
    "asymmetry": SetAsideItem("gyroscope asymmetry", "ppm", 10.0, _GYRO, _asymmetry),
    "nonlinearity": SetAsideItem("gyroscope nonlinearity at the turns' speed", "ppm", 10.0, _GYRO, _nonlinearity),
    "faces-in-turns": SetAsideItem("the drawing's tilts in the turns", "times", 1.0, "Yao 2018, 2: positions only",
                                   _faces_in_turns),
})  # fmt: skip


def set_aside_errors(sizes: Mapping[str, float], case: SetAsideCase) -> dict[str, dict[str, FloatArray]]:
    """Return 1 sigma (3,) by item and quantity of the items ``sizes``, by name, in their own units.

    Raises
    ------
    ValueError
        An item is unknown, or its size negative or no number; says what is expected.
    """
    if unknown := sorted(sizes.keys() - SET_ASIDE.keys()):
        raise ValueError(f"set-aside items {', '.join(unknown)} unknown, expected {', '.join(SET_ASIDE)}")
    for name, size in sizes.items():
        if not (np.isfinite(size) and size >= 0):
            raise ValueError(f"set-aside item {name} is {size} {SET_ASIDE[name].unit}, expected zero or more")
    return {name: SET_ASIDE[name].acts(size, case) for name, size in sizes.items()}


def combined(errors: Mapping[str, Mapping[str, FloatArray]]) -> dict[str, FloatArray]:
    """Return 1 sigma (3,) by quantity of all ``errors`` together, in `QUANTITIES`' units: variances add up."""
    total = {name: np.zeros(len(AXES)) for name in QUANTITIES}
    for found in errors.values():
        for name, sigma in found.items():
            total[name] = np.hypot(total[name], sigma)
    return total
