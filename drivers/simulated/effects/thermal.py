"""What temperature does to a bias: polynomials, a sensor that follows, warming against cooling.

The sensor's temperature is the convolution of the thermometer's with an exponential, by Gauss and Legendre; the
device was switched on in equilibrium.
"""

import numpy as np

from drivers.simulated.effects.planted_effect import AXES, REFERENCE_C, Stimulus, TriadInput
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray

HIGHEST = 5  # order that can be planted
POLYNOMIAL_KEYS = (*AXES, *(f"{axis}.{n}" for axis in AXES for n in range(1, HIGHEST + 1)))
LAG_OPTIONS = {"tau_s": 300.0}
PLAY_OPTIONS = {"play_k": 0.0}
GRID = 101  # times of a segment at which the sensor's temperature is worked out
PLAY_STEP_S = 1.0  # in which a play follows the temperature
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(96)


def polynomial(sizes: Sizes, temperature: FloatArray) -> FloatArray:
    """Return c1 (T - 25) + c2 (T - 25)^2 + ... (n, 3), in the effect's unit; keys x or x.1, x.2, ...

    ``temperature`` (n,) is in degC.
    """
    warmer = np.reshape(temperature, -1) - REFERENCE_C
    columns = []
    for axis in AXES:
        c = [sizes.get(f"{axis}.{n}", 0.0) for n in range(1, HIGHEST + 1)]
        c[0] += sizes.get(axis, 0.0)
        columns.append(np.polyval([*reversed(c), 0.0], warmer))
    return np.stack(columns, axis=1)


def polynomial_of_lag(sizes: Sizes, seen: Stimulus) -> FloatArray:
    """Return the same (n, 3) of the temperature that a sensor has come to with the time constant ``tau_s`` [s]."""
    return polynomial(sizes, sensor_temperature(seen, sizes["tau_s"]))


def scale_temperature(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    """Return what is added (n, 3), or (1, 3) [g, deg/s]: 1e-6 (c1 (T - 25) + ...) (u + D), c in ppm/K^n."""
    return 1e-6 * polynomial(sizes, stimulus.temperature) * (triad.raw + triad.bias)


def scale_temperature_lag(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    """Return the same (n, 3) [g, deg/s] of the temperature that a sensor has come to."""
    return 1e-6 * polynomial_of_lag(sizes, stimulus) * (triad.raw + triad.bias)


def direction(seen: Stimulus, sizes: Sizes) -> FloatArray:
    """Return 1 (n, 1), without unit, while it grows warmer, -1 while it cools; between within ``play_k`` [K]."""
    width = sizes.get("play_k", 0.0)
    found: FloatArray = np.sign(seen.temperature_rate) if width <= 0 else _play(seen, width)
    return found


def _play(seen: Stimulus, width: float) -> FloatArray:
    """Return by how many half widths T is ahead (n, 1) of what it pushes before itself from power-on on."""
    t = np.arange(0.0, float(np.max(seen.t)) + 2 * PLAY_STEP_S, PLAY_STEP_S)
    T, left = seen.temperature_at(t), np.empty(len(t))
    at = T[0]
    for i, now in enumerate(T):
        at = left[i] = now - width if now - at > width else now + width if at - now > width else at
    return np.interp(seen.t, t, (T - left) / width).reshape(-1, 1)


def sensor_temperature(seen: Stimulus, tau: float) -> FloatArray:
    """Return the temperature (n,) [degC] that a sensor has come to with the time constant ``tau`` [s]."""
    t = np.reshape(seen.t, -1)
    if len(t) <= GRID:
        return _convolved(seen, t, tau)
    grid = np.linspace(t[0], t[-1], GRID)
    return np.interp(t, grid, _convolved(seen, grid, tau))


def _convolved(seen: Stimulus, t: FloatArray, tau: float) -> FloatArray:
    """Return T(0) w0 + integral of T(t + tau ln w) dw from w0 = exp(-t / tau) to 1, at times t (n,) [s]."""
    begin = np.exp(-t / tau)[:, None]
    w = begin + (1 - begin) * (1 + _NODES) / 2
    past = np.maximum(t[:, None] + tau * np.log(np.maximum(w, 1e-300)), 0.0)
    inside = (seen.temperature_at(past) @ _WEIGHTS) / 2 * (1 - begin[:, 0])
    found: FloatArray = begin[:, 0] * seen.temperature_at(np.zeros(1)) + inside
    return found
