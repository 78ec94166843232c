"""Kinds that go with what a sensor feels: `docs/undeclared.md` has equations and sources."""

import numpy as np

from drivers.simulated.effects import Stimulus, TriadInput
from tests.benchmarks.undeclared_kinds.kind import Add, Drawn, Kind

FASTEST = 200.0  # deg/s, above every hand turn here


def lock_in(drawn: Drawn) -> Add:
    """Return the error of a ring laser locked at rest; the size is the width of the lock [deg/s]."""

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        u, width = triad.raw + triad.bias, size * np.abs(drawn.along)
        return np.sign(u) * np.sqrt(np.maximum(0.0, u**2 - width**2)) - u

    return add


def dead_zone(drawn: Drawn) -> Add:
    """Return a rate that is not seen where it is small; the size is the zone's width [deg/s]."""

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        u = triad.raw + triad.bias
        return -u * np.exp(-((u / np.maximum(size * np.abs(drawn.along), 1e-15)) ** 4))

    return add


def stiction(drawn: Drawn) -> Add:
    """Return what a proof mass that sticks does not follow [g]."""

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        width = np.maximum(size * np.abs(drawn.along), 1e-15)
        return -width * np.tanh((triad.raw + triad.bias) / width)

    return add


def quantised(drawn: Drawn) -> Add:
    """Return what coarse steps that nothing dithers leave [g]."""

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        u, step = triad.raw + triad.bias, np.maximum(size * np.abs(drawn.along), 1e-15)
        return step * np.round(u / step) - u

    return add


def converter(drawn: Drawn) -> Add:
    """Return the bow of a converter that goes up and down several times over the range."""
    period, phases = drawn.rng.uniform(0.2, 0.6, 3), drawn.phases()
    return lambda seen, triad, size: drawn.along * size * np.sin(2 * np.pi * triad.raw / period + phases)


def quadratic(drawn: Drawn) -> Add:
    """Return K2 u^2."""
    return lambda seen, triad, size: drawn.along * size * triad.raw**2


def cross_coupling(drawn: Drawn) -> Add:
    """Return K u_i u_p, the pendulous axis next to the input axis."""
    return lambda seen, triad, size: drawn.along * size * triad.raw * np.roll(triad.raw, -1, axis=1)


def cross_quadratic(drawn: Drawn) -> Add:
    """Return K_oo u_o^2, the output axis next to the input axis."""
    return lambda seen, triad, size: drawn.along * size * np.roll(triad.raw, -1, axis=1) ** 2


def g_sensitivity(drawn: Drawn) -> Add:
    """Return G f, any matrix."""
    G = drawn.along[:, None] * drawn.rng.uniform(-1, 1, (3, 3))
    return lambda seen, triad, size: size * np.einsum("qp,np->nq", G, seen.f)


def g_squared(drawn: Drawn) -> Add:
    """Return what is even in specific force: squares and products."""
    square, product = drawn.along[:, None] * drawn.rng.uniform(-1, 1, (2, 3, 3))

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        next_to = seen.f * np.roll(seen.f, -1, axis=1)
        return size * (np.einsum("qp,np->nq", square, seen.f**2) + np.einsum("qp,np->nq", product, next_to))

    return add


def magnetic(drawn: Drawn) -> Add:
    """Return M B, any matrix; the size is what 30 uT do."""
    M = drawn.along[:, None] * drawn.rng.uniform(-1, 1, (3, 3))
    return lambda seen, triad, size: size * np.einsum("qp,np->nq", M, seen.magnetic) / 30.0


def asymmetric(drawn: Drawn) -> Add:
    """Return a scale factor that differs between + and -."""
    return lambda seen, triad, size: drawn.along * size * np.abs(triad.raw)


def open_loop(drawn: Drawn) -> Add:
    """Return the first term of an open loop's sine; the size is its share at 100 deg/s."""
    return lambda seen, triad, size: drawn.along * size * triad.raw * (triad.raw / 100.0) ** 2


def rectified(drawn: Drawn) -> Add:
    """Return what a rate about the next axis brings, of either direction; the size is at 100 deg/s."""
    return lambda seen, triad, size: drawn.along * size * (np.roll(triad.raw, -1, axis=1) / 100.0) ** 2


def saturated(drawn: Drawn) -> Add:
    """Return what is beyond the range; the larger the size, the narrower."""

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        end = FASTEST * (1 - size * np.abs(drawn.along))
        return np.clip(triad.raw, -end, end) - triad.raw

    return add


def lost_counts(drawn: Drawn) -> Add:
    """Return what a counter loses above a rate: a share ``size`` of what is above."""
    from_deg_s = drawn.rng.uniform(20, 45)

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        above = np.maximum(0.0, np.abs(triad.raw) - from_deg_s)
        return -size * np.abs(drawn.along) * np.sign(triad.raw) * above

    return add


BY_INPUT = (
    Kind("K2", "accel", quadratic, "certified free", ("accelerometer.quadratic",)),
    Kind("cross-coupling of a pendulum", "accel", cross_coupling, "free", ("accelerometer.cross_product",)),
    Kind("g-sensitivity", "gyro", g_sensitivity, "plain", ("gyroscope.g_sensitivity",)),
    Kind("Faraday effect", "gyro", magnetic, "plain", ("gyroscope.magnetic",)),
    Kind("open loop at three speeds", "gyro", open_loop, "speeds",
         ("gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine")),
    Kind("asymmetry at three speeds", "gyro", asymmetric, "speeds", ("gyroscope.scale_asymmetry",)),
    Kind("lock-in", "gyro", lock_in, least=1e-5, most=3e-2),
    Kind("dead zone", "gyro", dead_zone, least=1e-5, most=3e-2),
    Kind("stiction", "accel", stiction, "free", least=1e-7, most=1e-2),
    Kind("no dither before a coarse step", "accel", quantised, "free", least=1e-7, most=1e-3),
    Kind("bow of a converter", "accel", converter, "free"),
    Kind("cross-axis K", "accel", cross_quadratic, "certified free"),
    Kind("g squared", "gyro", g_squared),
    Kind("magnet of a torquer", "accel", magnetic),
    Kind("rectified rate", "gyro", rectified, "speeds"),
    Kind("range ends", "gyro", saturated, "speeds", least=0.01, most=0.95),
    Kind("counts lost at rate", "gyro", lost_counts, "speeds"),
)  # fmt: skip
