"""Error terms of the sensors: what is added to ``E f + D`` [g] and ``E omega + D`` [deg/s]; IMU axes.

``triad.raw`` is E f or E omega, per sensor; T in degC, t in s. Sources: IEEE Std 1293 model equation (K2, K3,
cross products K_ij, scale-factor asymmetry); IEEE Std 952 model equation (temperature, temperature rate, magnetic,
acceleration sensitivity); Shupe 1980 (temperature rate); the Sagnac sine of an open-loop FOG: H. C. Lefevre, The
Fiber-Optic Gyroscope.

Temperature changes a bias by polynomials, through a sensor that follows, and by warming against cooling. The
sensor's temperature is the convolution of the thermometer's with an exponential, by Gauss and Legendre; the device
was switched on in equilibrium.
"""

from collections.abc import Callable
from itertools import combinations
from types import MappingProxyType

import numpy as np

from drivers.simulated.effects.planted_effect import (
    AXES,
    MATRIX_KEYS,
    REFERENCE_C,
    VECTOR_KEYS,
    Added,
    PlantedEffect,
    Stimulus,
    TriadInput,
    matrix,
    vector,
)
from drivers.simulated.truth import Sizes
from procedures.arrays import FloatArray
from procedures.units import DEG_H_PER_DEG_S, S_PER_H, S_PER_MIN

HIGHEST = 5  # order that can be planted
POLYNOMIAL_KEYS = (*AXES, *(f"{axis}.{n}" for axis in AXES for n in range(1, HIGHEST + 1)))
CYCLE_KEYS = tuple(f"{axis}.{part}" for axis in AXES for part in ("sin", "cos"))
LAG_OPTIONS = {"tau_s": 300.0}
PLAY_OPTIONS = {"play_k": 0.0}
JUMP_OPTIONS = {"after_s": 600.0, "scale": 0.0}
NO_OPTIONS: Sizes = MappingProxyType({})
Size = Callable[[Stimulus, Sizes], FloatArray]
BothTriads = tuple[PlantedEffect, PlantedEffect]
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


def _turned(sizes: Sizes, seen: FloatArray) -> FloatArray:
    """Return sensitivities [deg/h per unit] times what is seen (n or 1, 3) [unit]."""
    added: FloatArray = np.einsum("qp,np->nq", matrix(sizes), seen) / DEG_H_PER_DEG_S
    return added


def _within_range(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    """Return what an output lacks (n, 3) [deg/s] beyond the ends x+, x- ... of its range; it has none where 0."""
    out = triad.raw + triad.bias
    low = [sizes.get(axis + "-", 0.0) or -np.inf for axis in AXES]
    high = [sizes.get(axis + "+", 0.0) or np.inf for axis in AXES]
    found: FloatArray = np.clip(out, low, high) - out
    return found


def _counts_lost(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    out = triad.raw + triad.bias
    above = np.abs(out) - sizes["knee_deg_s"]
    return np.where(above > 0, -1e-6 * vector(sizes) * above * np.sign(out), 0.0)


def _bias(
    name: str, unit: tuple[str, str], keys: tuple[str, ...], size: Size, options: Sizes = NO_OPTIONS
) -> BothTriads:
    """Return what is planted in the biases of both triads; ``size`` returns it in the effect's unit."""

    def rate(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
        return size(seen, sizes) / DEG_H_PER_DEG_S

    return (
        PlantedEffect(f"accelerometer.{name}", unit[0], keys, options, accel=lambda s, _, sizes: size(s, sizes)),
        PlantedEffect(f"gyroscope.{name}", unit[1], keys, options, gyro=rate),
    )


def _scale(name: str, unit: str, keys: tuple[str, ...], size: Size, options: Sizes = NO_OPTIONS) -> BothTriads:
    """Return what is planted in the scale factors of both triads; ``size`` returns it in ppm."""

    def added(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
        return 1e-6 * size(seen, sizes) * (triad.raw + triad.bias)

    return (
        PlantedEffect(f"accelerometer.{name}", unit, keys, options, accel=added),
        PlantedEffect(f"gyroscope.{name}", unit, keys, options, gyro=added),
    )


def _warmed(seen: Stimulus, sizes: Sizes) -> FloatArray:
    return polynomial(sizes, seen.temperature)


def _lagged(seen: Stimulus, sizes: Sizes) -> FloatArray:
    return polynomial(sizes, sensor_temperature(seen, sizes["tau_s"]))


def _lagged_rate(seen: Stimulus, sizes: Sizes) -> FloatArray:
    """Return c dT_s/dt (n, 3), in K/min, of the temperature that a sensor has come to with ``tau_s`` [s]."""
    ahead = np.reshape(seen.temperature, -1) - sensor_temperature(seen, sizes["tau_s"])
    return vector(sizes) * S_PER_MIN * ahead[:, None] / sizes["tau_s"]


def _settling(seen: Stimulus, sizes: Sizes) -> FloatArray:
    settled: FloatArray = vector(sizes) * np.exp(-seen.t / sizes["tau_s"])
    return settled


def _cycle(seen: Stimulus, sizes: Sizes) -> FloatArray:
    phase = 2 * np.pi * seen.t / sizes["period_s"]
    sine, cosine = (np.array([sizes.get(f"{axis}.{part}", 0.0) for axis in AXES]) for part in ("sin", "cos"))
    added: FloatArray = sine * np.sin(phase) + cosine * np.cos(phase)
    return added


def _asymmetry(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    return 0.5e-6 * vector(sizes) * np.abs(triad.raw)


def _jump(unit: float) -> Added:
    """Return what adds ``unit`` times sizes, or ppm of the output, after ``after_s``."""

    def added(seen: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
        by = 1e-6 * (triad.raw + triad.bias) if sizes["scale"] else unit
        jumped: FloatArray = (seen.t > sizes["after_s"]) * vector(sizes) * by
        return jumped

    return added


BOTH = (
    *_bias("bias_temperature", ("g/K", "deg/h/K"), POLYNOMIAL_KEYS, _warmed),
    *_scale("scale_temperature", "ppm/K", POLYNOMIAL_KEYS, _warmed),
    *_bias("temperature_lag", ("g/K", "deg/h/K"), POLYNOMIAL_KEYS, _lagged, LAG_OPTIONS),
    *_scale("scale_temperature_lag", "ppm/K", POLYNOMIAL_KEYS, _lagged, LAG_OPTIONS),
    *_bias("temperature_rate", ("g/(K/min)", "deg/h/(K/min)"), VECTOR_KEYS,
           lambda seen, sizes: vector(sizes) * seen.temperature_rate),
    *_bias("temperature_hysteresis", ("g", "deg/h"), VECTOR_KEYS,
           lambda seen, sizes: vector(sizes) * direction(seen, sizes), PLAY_OPTIONS),
    *_bias("bias_settling", ("g", "deg/h"), VECTOR_KEYS, _settling, LAG_OPTIONS),
    *_scale("scale_settling", "ppm", VECTOR_KEYS, _settling, LAG_OPTIONS),
    *_bias("bias_cycle", ("g", "deg/h"), CYCLE_KEYS, _cycle, {"period_s": 600.0}),
    *_bias("bias_drift", ("g/h", "deg/h/h"), VECTOR_KEYS, lambda seen, sizes: vector(sizes) * seen.t / S_PER_H),
    PlantedEffect("accelerometer.scale_asymmetry", "ppm", VECTOR_KEYS, accel=_asymmetry),
    PlantedEffect("gyroscope.scale_asymmetry", "ppm", VECTOR_KEYS, gyro=_asymmetry),
    PlantedEffect("accelerometer.jump", "g", VECTOR_KEYS, JUMP_OPTIONS, accel=_jump(1.0)),
    PlantedEffect("gyroscope.jump", "deg/h", VECTOR_KEYS, JUMP_OPTIONS, gyro=_jump(1 / DEG_H_PER_DEG_S)),
)  # fmt: skip


GYROSCOPE = (
    PlantedEffect("gyroscope.g_sensitivity", "deg/h/g", MATRIX_KEYS,
                  gyro=lambda seen, triad, sizes: _turned(sizes, seen.f)),
    PlantedEffect("gyroscope.magnetic", "deg/h/uT", MATRIX_KEYS,
                  gyro=lambda seen, triad, sizes: _turned(sizes, seen.magnetic)),
    PlantedEffect("gyroscope.scale_nonlinearity", "ppm/(deg/s)", VECTOR_KEYS,
                  gyro=lambda seen, triad, sizes: 1e-6 * vector(sizes) * triad.raw * np.abs(triad.raw)),
    PlantedEffect("gyroscope.sagnac_sine", "rad/(deg/s)", VECTOR_KEYS,
                  gyro=lambda seen, triad, sizes: triad.raw * (np.sinc(vector(sizes) * triad.raw / np.pi) - 1)),
    PlantedEffect("gyroscope.temperature_rate_lag", "deg/h/(K/min)", VECTOR_KEYS, LAG_OPTIONS,
                  gyro=lambda seen, triad, sizes: _lagged_rate(seen, sizes) / DEG_H_PER_DEG_S),
    PlantedEffect("gyroscope.counts_lost", "ppm", VECTOR_KEYS, {"knee_deg_s": 30.0}, gyro=_counts_lost),
    PlantedEffect("gyroscope.saturation", "deg/s", tuple(axis + side for axis in AXES for side in "+-"),
                  gyro=_within_range),
)  # fmt: skip


_PRODUCT_KEYS = tuple(sensor + one + other for sensor in AXES for one, other in combinations(AXES, 2))
_OWN_KEYS = tuple(sensor + other for sensor in AXES for other in AXES if sensor != other)


def _cross_product(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    added = np.zeros(np.broadcast_shapes(triad.raw.shape, (1, 3)))
    for key in _PRODUCT_KEYS + _OWN_KEYS:
        if key in sizes:
            sensor, one, other = (AXES.index(axis) for axis in (key if len(key) == 3 else key[0] + key))
            added[:, sensor] += sizes[key] * (triad.raw[:, one] * triad.raw[:, other])
    return added


def _relaxation(stimulus: Stimulus, triad: TriadInput, sizes: Sizes) -> FloatArray:
    by = stimulus.f if sizes["by_force"] else 1.0
    added: FloatArray = vector(sizes) * by * np.exp(-stimulus.rest_s / sizes["tau_s"])
    return added


ACCELEROMETER = (
    PlantedEffect("accelerometer.quadratic", "g/g^2", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * triad.raw**2),
    PlantedEffect("accelerometer.cubic", "g/g^3", VECTOR_KEYS,
                  accel=lambda seen, triad, sizes: vector(sizes) * triad.raw**3),
    PlantedEffect("accelerometer.cross_product", "g/g^2", _OWN_KEYS + _PRODUCT_KEYS, accel=_cross_product),
    PlantedEffect("accelerometer.relaxation", "g", VECTOR_KEYS, {"tau_s": 30.0, "by_force": 0.0},
                  accel=_relaxation),
)  # fmt: skip


PER_OCTAVE = 8
HERTZ = 2.0 ** np.arange(-18, 0, 1 / PER_OCTAVE)  # from 3 days to 2 s
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
