"""Accelerometer effects: what is added to ``E f + D`` [g]; ``u`` is E f, per sensor, T in degC, t in s.

Sources: IEEE Std 1293 model equation (K2, K3, cross products K_ij, scale-factor asymmetry).
"""

from itertools import combinations_with_replacement

import numpy as np

from drivers.simulated.effects.planted_effect import (
    AXES,
    REFERENCE_C,
    VECTOR_KEYS,
    PlantedEffect,
    Stimulus,
    TriadInput,
    scale_asymmetry,
    scale_temperature,
    vector,
)
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import S_PER_H

_PAIRS = [AXES[i] + AXES[j] for i, j in combinations_with_replacement(range(3), 2) if i != j]
_PRODUCT_KEYS = tuple(f"{sensor}{pair}" for sensor in AXES for pair in _PAIRS)
_OWN_KEYS = tuple(sensor + other for sensor in AXES for other in AXES if sensor != other)


def _quadratic(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) * triad.raw**2


def _cubic(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) * triad.raw**3


def _cross_product(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    added = np.zeros(np.broadcast_shapes(triad.raw.shape, (1, 3)))
    for key in _PRODUCT_KEYS + _OWN_KEYS:
        if key in sizes:
            sensor, pair = key[0], key[1:] if len(key) == 3 else key
            product = triad.raw[:, AXES.index(pair[0])] * triad.raw[:, AXES.index(pair[1])]
            added[:, AXES.index(sensor)] += sizes[key] * product
    return added


def _bias_temperature(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) * (stimulus.temperature - REFERENCE_C)


def _bias_drift(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) * stimulus.t / S_PER_H


def _relaxation(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) * np.exp(-stimulus.rest_s / sizes["tau_s"])


ACCELEROMETER = (
    PlantedEffect("accelerometer.quadratic", "g/g^2", VECTOR_KEYS, accel=_quadratic),
    PlantedEffect("accelerometer.cubic", "g/g^3", VECTOR_KEYS, accel=_cubic),
    PlantedEffect("accelerometer.scale_asymmetry", "ppm", VECTOR_KEYS, accel=scale_asymmetry),
    PlantedEffect("accelerometer.cross_product", "g/g^2", _OWN_KEYS + _PRODUCT_KEYS, accel=_cross_product),
    PlantedEffect("accelerometer.bias_temperature", "g/K", VECTOR_KEYS, accel=_bias_temperature),
    PlantedEffect("accelerometer.scale_temperature", "ppm/K", VECTOR_KEYS, accel=scale_temperature),
    PlantedEffect("accelerometer.bias_drift", "g/h", VECTOR_KEYS, accel=_bias_drift),
    PlantedEffect("accelerometer.relaxation", "g", VECTOR_KEYS, {"tau_s": 30.0}, accel=_relaxation),
)
