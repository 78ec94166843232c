"""Kinds that go with time and with what was before: `docs/undeclared.md` has equations and sources."""

import numpy as np

from drivers.simulated.effects import Stimulus, TriadInput
from tests.benchmarks.undeclared_kinds.kind import Add, Drawn, Kind

HOUR_S = 3600.0
NODE_S = 5.0  # of a random walk, linear in between
LONG_S = 8000.0
REST_S = 5.0  # how long the cube has stood when a step begins


def drift(drawn: Drawn) -> Add:
    """Return a bias that drifts; the size is what an hour does."""
    return lambda seen, triad, size: drawn.along * size * seen.t / HOUR_S


def stepping(drawn: Drawn) -> Add:
    """Return a bias that steps once, as the cube is carried on or in a step."""
    when = drawn.rng.uniform(400, 1500)
    return lambda seen, triad, size: drawn.along * size * (seen.t > when)


def warm_up(drawn: Drawn) -> Add:
    """Return a bias that settles after power-on while the case is at one temperature."""
    tau = drawn.number(200, 600)
    return lambda seen, triad, size: drawn.along * size * np.exp(-seen.t / tau)


def source(drawn: Drawn) -> Add:
    """Return a scale factor that settles after power-on with the source's wavelength."""
    tau = drawn.number(200, 600)
    return lambda seen, triad, size: drawn.along * size * np.exp(-seen.t / tau) * triad.raw


def ageing(drawn: Drawn) -> Add:
    """Return a scale factor that goes on with time."""
    return lambda seen, triad, size: drawn.along * size * seen.t / HOUR_S * triad.raw


def supply(drawn: Drawn) -> Add:
    """Return a bias by a supply that sags and is charged."""
    period, phase = drawn.number(400, 900), drawn.rng.random()
    return lambda seen, triad, size: drawn.along * size * (2 * ((seen.t / period + phase) % 1.0) - 1)


def pressure(drawn: Drawn) -> Add:
    """Return a bias by a pressure that nobody records."""
    period, phase = drawn.number(300, 700), drawn.rng.uniform(0, 6.28)
    return lambda seen, triad, size: drawn.along * size * np.sin(2 * np.pi * seen.t / period + phase)


def dither(drawn: Drawn) -> Add:
    """Return a line that sampling has brought down."""
    hz, phases = drawn.number(0.3, 4.0), drawn.phases()
    return lambda seen, triad, size: drawn.along * size * np.sin(2 * np.pi * hz * seen.t + phases)


def telegraph(drawn: Drawn) -> Add:
    """Return a bias that is one of two, for a hundred seconds on average."""
    when = np.cumsum(drawn.rng.exponential(100.0, 400))
    return lambda seen, triad, size: (
        drawn.along * size * np.where(np.searchsorted(when, seen.t[:, 0]) % 2, 1.0, -1.0)[:, None]
    )


def walk(drawn: Drawn) -> Add:
    """Return a bias that walks; the size is 1 sigma after 1000 s."""
    t = np.arange(0.0, LONG_S, NODE_S)
    path = np.cumsum(drawn.rng.standard_normal((len(t), 3)), axis=0) * np.sqrt(NODE_S / 1000.0)

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        at = [np.interp(seen.t[:, 0], t, path[:, i]) for i in range(3)]
        return drawn.along * size * np.stack(at, axis=1)

    return add


class _Before:
    """The specific force of the step before, as each step's first sample finds it."""

    def __init__(self) -> None:
        self.now, self.before, self.last_s = np.zeros(3), np.zeros(3), -1.0

    def at(self, seen: Stimulus) -> tuple[np.ndarray, np.ndarray]:
        """Return the specific force before this step (3,) and the change to it."""
        now = seen.f.mean(axis=0)
        if seen.t[0, 0] > self.last_s + 1.0:
            self.before, self.now = self.now, now
        self.last_s = float(seen.t[-1, 0])
        return self.before, self.now - self.before


def remembers(drawn: Drawn) -> Add:
    """Return what a hinge keeps of the position before."""
    history = _Before()
    return lambda seen, triad, size: np.broadcast_to(drawn.along * size * history.at(seen)[0], (len(seen.t), 3))


def relaxes(drawn: Drawn) -> Add:
    """Return what a viscoelastic hinge still does after a flip."""
    history, tau = _Before(), drawn.number(10, 100)

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        fading = np.where(np.isfinite(seen.rest_s), np.exp(-np.minimum(seen.rest_s, 1e6) / tau), 0.0)
        return drawn.along * size * history.at(seen)[1] * fading

    return add


def creeps(drawn: Drawn) -> Add:
    """Return the creep of a glued joint after a flip, by the logarithm of time."""
    history = _Before()

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        rested = np.where(np.isfinite(seen.rest_s), seen.rest_s, 0.0)
        return drawn.along * size * history.at(seen)[1] * np.log1p(rested / 3.0)

    return add


def self_heating(drawn: Drawn) -> Add:
    """Return the warmth that turning leaves in a gyroscope; the size is one of a full minute at 45 deg/s."""
    tau = drawn.number(100, 300)
    kept = {"heat": 0.0, "t": 0.0}

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        t = seen.t[:, 0]
        step = t[1] - t[0] if len(t) > 1 else 0.1
        power = np.broadcast_to(np.sum(seen.omega**2, axis=1) / (60 * 45.0**2), t.shape)
        begin = kept["heat"] * np.exp(-(t[0] - kept["t"]) / tau)
        since = t - t[0]
        heat = np.exp(-since / tau) * (begin + np.cumsum(power * np.exp(since / tau)) * step)
        kept["heat"], kept["t"] = float(heat[-1]), float(t[-1])
        return drawn.along * size * heat[:, None]

    return add


def rectification(drawn: Drawn) -> Add:
    """Return K2 sigma^2 of steps that shake: the shaking shows in every channel, its mean in the bias.

    The size is K2 [g/g^2]; some steps shake by 0.01 to 0.05 g rms at 1.3 to 4.2 Hz, whatever the size.
    """
    shaking = drawn.rng.random(200) < 0.4
    rms, hz = drawn.rng.uniform(0.01, 0.05, 200), drawn.rng.uniform(1.3, 4.2, 200)

    def add(seen: Stimulus, triad: TriadInput, size: float) -> np.ndarray:
        step = int(seen.t[0, 0] / 20.0) % 200
        wave = rms[step] * np.sqrt(2.0) * np.sin(2 * np.pi * hz[step] * seen.t) * shaking[step]
        shaken: np.ndarray = wave * np.abs(np.sign(drawn.along)) + size * wave**2 * drawn.along
        return shaken

    return add


BY_TIME = (
    Kind("bias drifts", "gyro", drift, "plain", ("gyroscope.bias_drift",)),
    Kind("bias steps once", "gyro", stepping, "plain", ("gyroscope.jump",)),
    Kind("viscoelastic hinge", "accel", relaxes, "plain", ("accelerometer.relaxation",)),
    Kind("source warms up", "gyro", source, "speeds", most=0.5),
    Kind("hinge remembers", "accel", remembers),
    Kind("supply sags", "accel", supply),
    Kind("self-heating by turning", "gyro", self_heating),
    Kind("telegraph noise", "gyro", telegraph),
    Kind("rate random walk", "accel", walk),
    Kind("scale factor ages", "accel", ageing),
    Kind("dither's residue", "gyro", dither, "plain", ("disturbance.line",), block_s=0.1),
    Kind("bias warms up by itself", "gyro", warm_up),
    Kind("glued joint creeps", "accel", creeps),
    Kind("pressure cycles", "accel", pressure),
    Kind("vibration rectification", "accel", rectification, "plain", ("accelerometer.vibration_rectification",),
         most=1.0, of_bench=("disturbance.dwell", "disturbance.line")),
)  # fmt: skip
