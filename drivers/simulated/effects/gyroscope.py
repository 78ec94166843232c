"""Gyroscope effects: what is added to ``E omega + D`` [deg/s]; ``u`` is E omega, f in g, B in uT, IMU axes.

Sources: IEEE Std 952 model equation (temperature, temperature rate, magnetic, acceleration sensitivity);
Shupe 1980 (temperature rate); the Sagnac sine of an open-loop FOG: H. C. Lefevre, The Fiber-Optic Gyroscope.
"""

import numpy as np

from drivers.simulated.effects.planted_effect import (
    MATRIX_KEYS,
    REFERENCE_C,
    VECTOR_KEYS,
    Effect,
    Felt,
    Stimulus,
    matrix,
    scale_asymmetry,
    scale_temperature,
    vector,
)
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S, S_PER_H


def _g_sensitivity(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    added: FloatArray = np.einsum("qp,np->nq", matrix(sizes), seen.f) / DEG_H_PER_DEG_S
    return added


def _magnetic(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    added: FloatArray = np.einsum("qp,np->nq", matrix(sizes), seen.magnetic) / DEG_H_PER_DEG_S
    return added


def _bias_temperature(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * (seen.temperature - REFERENCE_C)


def _temperature_rate(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * seen.temperature_rate


def _bias_drift(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * seen.t / S_PER_H


def _nonlinearity(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    return 1e-6 * vector(sizes) * felt.raw * np.abs(felt.raw)


def _sagnac_sine(seen: Stimulus, felt: Felt, sizes: Sizes) -> FloatArray:
    phase = vector(sizes) * felt.raw
    return felt.raw * (np.sinc(phase / np.pi) - 1)


GYROSCOPE = (
    Effect("gyroscope.g_sensitivity", "deg/h/g", MATRIX_KEYS, gyro=_g_sensitivity),
    Effect("gyroscope.bias_temperature", "deg/h/K", VECTOR_KEYS, gyro=_bias_temperature),
    Effect("gyroscope.scale_temperature", "ppm/K", VECTOR_KEYS, gyro=scale_temperature),
    Effect("gyroscope.temperature_rate", "deg/h/(K/min)", VECTOR_KEYS, gyro=_temperature_rate),
    Effect("gyroscope.bias_drift", "deg/h/h", VECTOR_KEYS, gyro=_bias_drift),
    Effect("gyroscope.magnetic", "deg/h/uT", MATRIX_KEYS, gyro=_magnetic),
    Effect("gyroscope.scale_asymmetry", "ppm", VECTOR_KEYS, gyro=scale_asymmetry),
    Effect("gyroscope.scale_nonlinearity", "ppm/(deg/s)", VECTOR_KEYS, gyro=_nonlinearity),
    Effect("gyroscope.sagnac_sine", "rad/(deg/s)", VECTOR_KEYS, gyro=_sagnac_sine),
)
