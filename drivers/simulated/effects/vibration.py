"""A bench that shakes in every other position, and sensors whose mean follows the variance."""

import numpy as np

from drivers.simulated.effects.planted_effect import VECTOR_KEYS, PlantedEffect, Stimulus, TriadInput, vector
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S

OPTIONS = {"rms_g": 0.02, "hz": 2.3}
AXES_SHAKEN = 3


def _wave(seen: Stimulus, sizes: Sizes) -> FloatArray:
    """Return the vibration (n, 1) [g], the same along every axis, in odd positions."""
    amplitude = np.sqrt(2.0) * sizes["rms_g"] * (seen.position % 2)
    found: FloatArray = amplitude * np.sin(2 * np.pi * sizes["hz"] * np.reshape(seen.t, (-1, 1)))
    return found


def _accelerometers(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    wave = _wave(seen, sizes)
    return wave + vector(sizes) * wave**2


def _gyroscopes(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * AXES_SHAKEN * _wave(seen, sizes) ** 2


VIBRATION = (
    PlantedEffect("accelerometer.vibration_rectification", "g/g^2", VECTOR_KEYS, OPTIONS,
                  accel=_accelerometers),
    PlantedEffect("gyroscope.vibration_rectification", "deg/h/g^2", VECTOR_KEYS, OPTIONS,
                  accel=lambda seen, triad, sizes: _wave(seen, sizes) + np.zeros(3), gyro=_gyroscopes),
)  # fmt: skip
