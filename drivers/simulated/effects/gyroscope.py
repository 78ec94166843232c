"""Gyroscope effects: what is added to ``E omega + D`` [deg/s]; ``u`` is E omega, f in g, B in uT, IMU axes.

Sources: IEEE Std 952 model equation (temperature, temperature rate, magnetic, acceleration sensitivity);
Shupe 1980 (temperature rate); the Sagnac sine of an open-loop FOG: H. C. Lefevre, The Fiber-Optic Gyroscope.
"""

import numpy as np

from drivers.simulated.effects.planted_effect import (
    MATRIX_KEYS,
    REFERENCE_C,
    VECTOR_KEYS,
    PlantedEffect,
    Stimulus,
    TriadInput,
    matrix,
    scale_asymmetry,
    scale_temperature,
    vector,
)
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S, S_PER_H


def _g_sensitivity(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    added: FloatArray = np.einsum("qp,np->nq", matrix(sizes), stimulus.f) / DEG_H_PER_DEG_S
    return added


def _magnetic(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    added: FloatArray = np.einsum("qp,np->nq", matrix(sizes), stimulus.magnetic) / DEG_H_PER_DEG_S
    return added


def _bias_temperature(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * (stimulus.temperature - REFERENCE_C)


def _temperature_rate(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * stimulus.temperature_rate


def _bias_drift(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return vector(sizes) / DEG_H_PER_DEG_S * stimulus.t / S_PER_H


def _nonlinearity(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return 1e-6 * vector(sizes) * triad.raw * np.abs(triad.raw)


def _sagnac_sine(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    phase = vector(sizes) * triad.raw
    return triad.raw * (np.sinc(phase / np.pi) - 1)


GYROSCOPE = (
    PlantedEffect("gyroscope.g_sensitivity", "deg/h/g", MATRIX_KEYS, gyro=_g_sensitivity),
    PlantedEffect("gyroscope.bias_temperature", "deg/h/K", VECTOR_KEYS, gyro=_bias_temperature),
    PlantedEffect("gyroscope.scale_temperature", "ppm/K", VECTOR_KEYS, gyro=scale_temperature),
    PlantedEffect("gyroscope.temperature_rate", "deg/h/(K/min)", VECTOR_KEYS, gyro=_temperature_rate),
    PlantedEffect("gyroscope.bias_drift", "deg/h/h", VECTOR_KEYS, gyro=_bias_drift),
    PlantedEffect("gyroscope.magnetic", "deg/h/uT", MATRIX_KEYS, gyro=_magnetic),
    PlantedEffect("gyroscope.scale_asymmetry", "ppm", VECTOR_KEYS, gyro=scale_asymmetry),
    PlantedEffect("gyroscope.scale_nonlinearity", "ppm/(deg/s)", VECTOR_KEYS, gyro=_nonlinearity),
    PlantedEffect("gyroscope.sagnac_sine", "rad/(deg/s)", VECTOR_KEYS, gyro=_sagnac_sine),
)
