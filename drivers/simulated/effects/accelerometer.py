"""Accelerometer effects: what is added to ``E f + D`` [g]; ``triad.raw`` is E f, per sensor, T in degC, t in s.

Sources: IEEE Std 1293 model equation (K2, K3, cross products K_ij, scale-factor asymmetry).
"""

from itertools import combinations

import numpy as np

from drivers.simulated.effects.planted_effect import (
    AXES,
    JUMP_OPTIONS,
    REFERENCE_C,
    VECTOR_KEYS,
    PlantedEffect,
    Stimulus,
    TriadInput,
    jump,
    scale_asymmetry,
    scale_temperature,
    vector,
)
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import S_PER_H

_PRODUCT_KEYS = tuple(sensor + one + other for sensor in AXES for one, other in combinations(AXES, 2))
_OWN_KEYS = tuple(sensor + other for sensor in AXES for other in AXES if sensor != other)


def _cross_product(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    added = np.zeros(np.broadcast_shapes(triad.raw.shape, (1, 3)))
    for key in _PRODUCT_KEYS + _OWN_KEYS:
        if key in sizes:
            sensor, one, other = (AXES.index(axis) for axis in (key if len(key) == 3 else key[0] + key))
            added[:, sensor] += sizes[key] * (triad.raw[:, one] * triad.raw[:, other])
    return added


ACCELEROMETER = (
    PlantedEffect("accelerometer.quadratic", "g/g^2", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * triad.raw**2),
    PlantedEffect("accelerometer.cubic", "g/g^3", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * triad.raw**3),
    PlantedEffect("accelerometer.scale_asymmetry", "ppm", VECTOR_KEYS, accel=scale_asymmetry),
    PlantedEffect("accelerometer.cross_product", "g/g^2", _OWN_KEYS + _PRODUCT_KEYS, accel=_cross_product),
    PlantedEffect("accelerometer.bias_temperature", "g/K", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * (seen.temperature - REFERENCE_C)),
    PlantedEffect("accelerometer.scale_temperature", "ppm/K", VECTOR_KEYS, accel=scale_temperature),
    PlantedEffect("accelerometer.bias_drift", "g/h", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * seen.t / S_PER_H),
    PlantedEffect("accelerometer.relaxation", "g", VECTOR_KEYS, {"tau_s": 30.0},
                  accel=lambda seen, triad, sizes: vector(sizes) * np.exp(-seen.rest_s / sizes["tau_s"])),
    PlantedEffect("accelerometer.jump", "g", VECTOR_KEYS, JUMP_OPTIONS,
                  accel=lambda seen, triad, sizes: jump(seen, triad, sizes, 1.0)),
)  # fmt: skip
