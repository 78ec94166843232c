"""Kinds that go with temperature: `docs/undeclared.md` has equations and sources. ``size`` is in g or deg/s."""

import numpy as np

from drivers.simulated.effects import Stimulus, TriadInput
from tests.benchmarks.undeclared_kinds.kind import GRID_S, Add, Drawn, Kind

WIDE_K = 5.0  # temperatures by which sizes are scaled


def bends(drawn: Drawn) -> Add:
    """Return a bias that is a parabola of temperature."""
    first = drawn.rng.uniform(-0.5, 0.5)
    return lambda seen, triad, size: drawn.along * size * _power(seen, (first, 1.0))


def cubic(drawn: Drawn) -> Add:
    """Return a bias that is a straight line and a cube of temperature."""
    first = drawn.rng.uniform(-0.5, 0.5)
    return lambda seen, triad, size: drawn.along * size * _power(seen, (first, 0.0, 1.0))


def _power(seen: Stimulus, shares: tuple[float, ...]) -> np.ndarray:
    at = (seen.temperature - 25.0) / WIDE_K
    return np.asarray(sum(share * at ** (i + 1) for i, share in enumerate(shares)))


def lags(drawn: Drawn) -> Add:
    """Return a bias by a temperature that follows the recorded one; an exact step of the first order."""
    t, T = drawn.temperature()
    keep, own = np.exp(-GRID_S / drawn.number(120, 900)), np.empty(len(T))
    own[0] = T[0]
    for i in range(1, len(T)):
        own[i] = keep * own[i - 1] + (1 - keep) * (T[i] + T[i - 1]) / 2
    return lambda seen, triad, size: drawn.along * size * (np.interp(seen.t, t, own) - 25.0) / WIDE_K


def rate(drawn: Drawn) -> Add:
    """Return a bias by the rate of temperature [K/min]."""
    return lambda seen, triad, size: drawn.along * size * seen.temperature_rate


def hysteresis(drawn: Drawn) -> Add:
    """Return a bias that differs between warming and cooling: the classical play operator."""
    t, T = drawn.temperature()
    play, left = drawn.rng.uniform(1, 2), np.empty(len(T))
    at = T[0]
    for i, now in enumerate(T):
        at = left[i] = min(max(at, now - play), now + play)
    return lambda seen, triad, size: drawn.along * size * np.interp(seen.t, t, (T - left) / play)


def scale(drawn: Drawn) -> Add:
    """Return a scale factor that goes with temperature."""
    return lambda seen, triad, size: drawn.along * size * (seen.temperature - 25) / WIDE_K * triad.raw


def polarization(drawn: Drawn) -> Add:
    """Return a bias that interferes: a sine of temperature of a period that a campaign passes several times."""
    period, phases = drawn.number(1.0, 2.5), drawn.phases()
    return lambda seen, triad, size: drawn.along * size * np.sin(2 * np.pi * seen.temperature / period + phases)


def convection(drawn: Drawn) -> Add:
    """Return a bias that warms by which side is up, after each placing."""
    tau = drawn.number(20, 60)

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        grown = -np.expm1(-np.minimum(seen.rest_s, 1e6) / tau)
        return drawn.along * size * seen.f**2 * np.where(np.isfinite(seen.rest_s), grown, 0.0)

    return add


def _of(triad: str, name: str) -> tuple[str, ...]:
    return ({"accel": "accelerometer", "gyro": "gyroscope"}[triad] + "." + name,)


THERMAL = (
    Kind("accelerometer bias bends with temperature", "accel", bends, "soak", _of("accel", "bias_temperature")),
    Kind("gyroscope bias cubic in temperature", "gyro", cubic, "soak", _of("gyro", "bias_temperature")),
    Kind("accelerometer's temperature lags", "accel", lags, "soak", _of("accel", "temperature_lag")),
    Kind("gyroscope's temperature lags", "gyro", lags, "soak", _of("gyro", "temperature_lag")),
    Kind("Shupe effect", "gyro", rate, "soak", _of("gyro", "temperature_rate")),
    Kind("gradient across an accelerometer", "accel", rate, "soak", _of("accel", "temperature_rate")),
    Kind("hysteresis of quartz", "accel", hysteresis, "soak", _of("accel", "temperature_hysteresis")),
    Kind("hysteresis of a MEMS package", "gyro", hysteresis, "soak", _of("gyro", "temperature_hysteresis")),
    Kind("torquer over temperature", "accel", scale, "two temperatures", _of("accel", "scale_temperature")),
    Kind("polarization", "gyro", polarization, "soak"),
    Kind("convection", "gyro", convection),
)
