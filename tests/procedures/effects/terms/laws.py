"""Laws of the literature that are in no catalogue: each as a term, and its truth in plain numpy next to it.

Written before the grammar; the truths share nothing with it. Of the kinds of `docs/explanation/undeclared.md`
four are no expression of what a campaign knows: popcorn noise, a random walk, quantisation and a supply that sags
by itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

DPH = 1 / 3600.0  # deg/s of a deg/h


@dataclass(frozen=True)
class Seen:
    """What sensors went through at n nodes in plain units: g, deg/s, uT, degC, K/s, s."""

    f: np.ndarray
    w: np.ndarray
    B: np.ndarray
    T: np.ndarray
    T_per_s: np.ndarray
    t: np.ndarray
    t_step: np.ndarray
    before: np.ndarray
    north: np.ndarray
    east: np.ndarray
    aux: np.ndarray


@dataclass(frozen=True)
class Law:
    """``truth`` returns what a unit of each coefficient of a sensor adds, (n, 3) or (n, 3, k) [g], [deg/s]."""

    name: str
    source: str
    triad: str
    term: str | tuple[str, ...]
    unit: str
    truth: Callable[..., np.ndarray]
    at: dict[str, float] = field(default_factory=dict)
    shape: dict[str, tuple[str, float, float]] = field(default_factory=dict)
    plausible: float = 1.0


def one(value: np.ndarray) -> np.ndarray:
    """Return a value (n,) for three sensors."""
    return np.repeat(value[:, None], 3, axis=1)


def next_axis(v: np.ndarray, by: int) -> np.ndarray:
    """Return of sensors x, y, z what is along y, z, x, or with 2 along z, x, y."""
    return v[:, [(i + by) % 3 for i in range(3)]]


def lagged(t: np.ndarray, x: np.ndarray, tau: float) -> np.ndarray:
    """Return tau dy/dt = x - y in 1 ms steps of straight lines, begun at the first x."""
    grid = np.arange(t[0], t[-1] + 1e-3, 1e-3)
    line, y = np.interp(grid, t, x), np.empty(len(grid))
    y[0] = x[0]
    a = np.exp(-1e-3 / tau)
    for i in range(1, len(grid)):
        y[i] = a * y[i - 1] + (1 - a) * 0.5 * (line[i] + line[i - 1])
    return np.interp(t, grid, y)


def mean_before(t: np.ndarray, x: np.ndarray, tau: float) -> np.ndarray:
    """Return the mean of straight lines over the last tau seconds, x as at its beginning before that."""
    return np.array([np.interp(np.linspace(end - tau, end, 20001), t, x).mean() for end in t])


def both(phase: np.ndarray, unit: float) -> np.ndarray:
    """Return sine and cosine (n, 3, 2)."""
    return unit * np.stack((np.sin(phase), np.cos(phase)), axis=2)


LAWS = (
    Law("dead_zone", "Lefevre 10.3", "gyroscope", "-u * exp(-(u / w)**4)", "1",
        lambda s, w: -s.w * np.exp(-((s.w / (w * DPH)) ** 4)), {"w": 20.0}, {"w": ("deg/h", 1, 100)}),
    Law("lock_in", "Aronowitz 1971", "gyroscope", "sign(u) * sqrt(max(0, u**2 - w**2)) - u", "1",
        lambda s, w: np.sign(s.w) * np.sqrt(np.maximum(0, s.w**2 - (w * DPH) ** 2)) - s.w, {"w": 30.0},
        {"w": ("deg/h", 1, 100)}),
    Law("stiction", "IEEE 2700, threshold", "accelerometer", "-w * tanh(u / w)", "1",
        lambda s, w: -1e-6 * w * np.tanh(s.f / (1e-6 * w)), {"w": 3e5}, {"w": ("ug", 10, 1e6)}),
    Law("polarization", "Lefevre 5.3", "gyroscope", ("sin(2 * pi * T / P)", "cos(2 * pi * T / P)"), "deg/h",
        lambda s, P: both(one(2 * np.pi * (s.T - 25) / P), DPH), {"P": 1.7}, {"P": ("K", 1, 2.5)}),
    Law("wavelength_warm_up", "Lefevre 9.2", "gyroscope", "u * exp(-t / tau)", "ppm",
        lambda s, tau: 1e-6 * s.w * one(np.exp(-s.t / tau)), {"tau": 300.0}, {"tau": ("s", 200, 600)}),
    Law("hinge_memory", "IEEE 1293, hysteresis", "accelerometer", "f_before", "ug/g", lambda s: 1e-6 * s.before),
    Law("anisoelastic", "Titterton and Weston 4.2", "gyroscope", ("f**2", "f_2 * f_3"), "deg/h/g^2",
        lambda s: DPH * np.stack((s.f**2, next_axis(s.f, 1) * next_axis(s.f, 2)), axis=2)),
    Law("cross_axis_square", "IEEE 1293, K_oo", "accelerometer", "f_2**2", "ug/g^2",
        lambda s: 1e-6 * next_axis(s.f, 1) ** 2),
    Law("converter_bow", "data sheets, INL", "accelerometer", ("sin(2*pi*u/q)", "cos(2*pi*u/q)"), "ug",
        lambda s, q: both(2 * np.pi * s.f / q, 1e-6), {"q": 0.4}, {"q": ("g", 0.2, 0.6)}),
    Law("self_heating", "IEEE 952", "gyroscope", "lag(omega_norm**2, tau)", "deg/h/(deg/s)^2",
        lambda s, tau: DPH * one(lagged(s.t, np.sum(s.w**2, axis=1), tau)), {"tau": 200.0},
        {"tau": ("s", 100, 300)}),
    Law("torquer_magnet", "IEEE 1293", "accelerometer", ("B_x", "B_y", "B_z"), "ug/uT",
        lambda s: 1e-6 * np.repeat(s.B[:, None, :], 3, axis=1)),
    Law("scale_ages", "IEEE 1293, stability", "accelerometer", "t * u", "ppm/h",
        lambda s: 1e-6 * one(s.t / 3600) * s.f),
    Law("rectified_rate", "Titterton and Weston 4.5", "gyroscope", "omega_2**2", "deg/s/(deg/s)^2",
        lambda s: next_axis(s.w, 1) ** 2),
    Law("range_ends", "IEEE 2700, full scale", "gyroscope", "min(max(u, -w), w) - u", "1",
        lambda s, w: np.clip(s.w, -w, w) - s.w, {"w": 60.0}, {"w": ("deg/s", 50, 100)}),
    Law("lost_counts", "IEEE 836", "gyroscope", "-sign(u) * max(0, abs(u) - 40 [deg/s])", "ppm",
        lambda s: -1e-6 * np.sign(s.w) * np.maximum(0, np.abs(s.w) - 40)),
    Law("convection", "IEEE 952, orientation", "gyroscope", "f**2 * (1 - exp(-t_step / tau))", "deg/h/g^2",
        lambda s, tau: DPH * s.f**2 * one(1 - np.exp(-s.t_step / tau)), {"tau": 40.0}, {"tau": ("s", 20, 60)}),
    Law("bias_warm_up", "IEEE 952, warm-up time", "gyroscope", "exp(-t / tau)", "deg/h",
        lambda s, tau: DPH * one(np.exp(-s.t / tau)), {"tau": 400.0}, {"tau": ("s", 200, 600)}),
    Law("glue_creep", "IEEE 1293; creep of epoxy", "accelerometer", "log(1 + t_step / 3 [s]) * (f - f_before)",
        "ug/g", lambda s: 1e-6 * one(np.log(1 + s.t_step / 3)) * (s.f - s.before)),
    Law("cabin_pressure", "IEEE 952, environment", "gyroscope", ("sin(2*pi*t/P)", "cos(2*pi*t/P)"), "deg/h",
        lambda s, P: both(one(2 * np.pi * s.t / P), DPH), {"P": 500.0}, {"P": ("s", 300, 700)}),
    Law("temperature_and_rate", "Lefevre 6.2", "gyroscope", "T * T_rate", "deg/h/K/(K/min)",
        lambda s: DPH * one((s.T - 25) * s.T_per_s * 60)),
    Law("heater_behind", "IEEE 1293, thermal", "accelerometer", "smooth(aux_heater, tau)", "ug/unit",
        lambda s, tau: 1e-6 * one(mean_before(s.t, s.aux, tau)), {"tau": 90.0}, {"tau": ("s", 30, 300)}),
    Law("of_the_heading", "IEEE 952, orientation", "gyroscope", ("north**2 - east**2", "north * east"), "deg/h",
        lambda s: DPH * np.stack((s.north**2 - s.east**2, s.north * s.east), axis=2)),
    Law("lever_arm", "Titterton and Weston 8.4", "accelerometer", "omega_2**2 + omega_3**2", "g/(deg/s)^2",
        lambda s: next_axis(s.w, 1) ** 2 + next_axis(s.w, 2) ** 2),
)  # fmt: skip
