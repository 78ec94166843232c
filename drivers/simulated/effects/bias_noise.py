"""Bias instability and random walk to plant: sums of sines of random phase, a few an octave.

A sensor's power spectral density (one-sided) is ``B^2 / (pi f)``, of a walk ``2 K^2 / (2 pi f)^2``. Its integral
over the part of an octave that a sine stands for is half the square of the sine's amplitude.
"""

from collections.abc import Callable

import numpy as np

from drivers.simulated.effects.planted_effect import Added, PlantedEffect, Stimulus, TriadInput
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S, S_PER_H

PER_OCTAVE = 8
HERTZ = 2.0 ** np.arange(-18, 0, 1 / PER_OCTAVE)  # from 3 days to 2 s
BothTriads = tuple[PlantedEffect, PlantedEffect]
Amplitudes = Callable[[float], FloatArray]
STEP_S = 1.0  # between the points that are computed: straight lines between them


def _flicker(size: float) -> FloatArray:
    """Return the amplitudes of the sines of a bias instability, in its unit."""
    return np.full(len(HERTZ), size * np.sqrt(2 * np.log(2) / np.pi / PER_OCTAVE))


def _walk(size: float) -> FloatArray:
    """Return the amplitudes of the sines of a walk by ``size`` in a root of an hour."""
    power = 2 * size**2 / S_PER_H / (2 * np.pi * HERTZ) ** 2
    found: FloatArray = np.sqrt(2 * power * HERTZ * np.log(2) / PER_OCTAVE)
    return found


def _added(amplitudes: Amplitudes, per: float) -> Added:
    def added(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
        t = seen.t[:, 0]
        grid = np.arange(np.floor(t[0] / STEP_S), np.ceil(t[-1] / STEP_S) + 1) * STEP_S
        waves, size = 2 * np.pi * np.outer(grid, HERTZ), amplitudes(sizes["value"] / per)
        phases = np.random.default_rng(int(sizes["seed"])).uniform(0, 2 * np.pi, (3, len(HERTZ)))
        return np.stack([np.interp(t, grid, np.sin(waves + phase) @ size) for phase in phases], axis=1)

    return added


def _of_both(name: tuple[str, str], unit: tuple[str, str], amplitudes: Amplitudes) -> BothTriads:
    """Return what is planted in the accelerometers and in the gyroscopes."""
    accel, gyro = _added(amplitudes, 1.0), _added(amplitudes, DEG_H_PER_DEG_S)
    options = {"seed": 1.0}
    return (
        PlantedEffect(f"accelerometer.{name[0]}", unit[0], ("value",), options, accel=accel),
        PlantedEffect(f"gyroscope.{name[1]}", unit[1], ("value",), options, gyro=gyro),
    )


BIAS_NOISE = (
    *_of_both(("bias_instability", "bias_instability"), ("g", "deg/h"), _flicker),
    *_of_both(("acceleration_random_walk", "rate_random_walk"), ("g/sqrt(h)", "deg/h/sqrt(h)"), _walk),
)
