"""calibration/1 evaluated from its pages' equations, with none of the product.

The pages are docs/reference/file-formats.md and docs/reference/effects.md.
Written a sample at a time, slowly: u by fixed point, the temperature followed in closed form between two samples.
"""

from copy import deepcopy
from math import exp
from typing import Any

import numpy as np

G0 = 9.80665


def _axes(entry: dict[str, Any]) -> np.ndarray:
    return np.array([entry["coefficients"].get(axis, {"value": 0.0})["value"] for axis in "xyz"])


def lag(t: np.ndarray, T: np.ndarray, tau: float) -> np.ndarray:
    """``tau y' = T - y`` for T that goes straight: y = T - m tau + c exp(-t / tau)."""
    y = [T[0]]
    for i in range(1, len(t)):
        dt = t[i] - t[i - 1]
        m = (T[i] - T[i - 1]) / dt
        y.append(T[i] - m * tau + (y[-1] - T[i - 1] + m * tau) * exp(-dt / tau))
    return np.array(y)


def slope(t: np.ndarray, T: np.ndarray) -> np.ndarray:
    """K/min, a straight line through temperatures a second apart of the last minute."""
    kept, found, now = list[tuple[float, float]](), [], 0.0
    for at, value in zip(t.tolist(), T.tolist(), strict=True):
        if not kept or at - kept[-1][0] >= 1.0:
            kept = [each for each in kept if at - each[0] <= 60.0] + [(at, value)]
            x, y = np.array(kept).T
            now = 60 * np.polynomial.Polynomial.fit(x - at, y, 1).convert().coef[1] if x[-1] - x[0] >= 10 else 0.0
        found.append(now)
    return np.array(found)


def direction(T: np.ndarray) -> np.ndarray:
    way, low, high, found = 0, T[0], T[0], []
    for value in T.tolist():
        low, high = min(low, value), max(high, value)
        if way <= 0 and value > low + 0.5:
            way, low, high = 1, value, value
        elif way >= 0 and value < high - 0.5:
            way, low, high = -1, value, value
        found.append(way)
    return np.array(found)


def branch(T: np.ndarray, width: float) -> np.ndarray:
    """(T - P) / w, P pushed along by the temperature where that is farther than w away, from T's first on."""
    pushed = [T[0]]
    for value in T[1:].tolist():
        beyond = value - pushed[-1]
        pushed.append(pushed[-1] if abs(beyond) <= width else value - np.sign(beyond) * width)
    return (T - np.array(pushed)) / width


def evaluated(document: dict[str, Any], rates: np.ndarray, t: np.ndarray, T: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return specific force [m/s2] and rate [rad/s] of ``rates`` (n, 6) [count/s], gyroscopes first."""
    triads = {}
    for name, per in (("accelerometer", 1.0), ("gyroscope", 1 / 3600)):
        part = document[name]
        triads[name] = [np.array(part[each]["value"]) for each in ("scale_factor", "misalignment", "bias")]
        triads[name][2] = triads[name][2] * per
    warm, rate, way = T - 25.0, slope(t, T), direction(T)
    output = {"accelerometer": rates[:, 3:], "gyroscope": rates[:, :3]}
    u = {name: np.linalg.solve(E, (output[name] / k - D).T).T for name, (k, E, D) in triads.items()}
    for _ in range(60):
        added = {name: np.zeros_like(value) for name, value in u.items()}
        for entry in document["effects"]:
            triad, _, name = entry["name"].partition(".")
            per = 1.0 if triad == "accelerometer" else 1 / 3600
            c, v = _axes(entry), u[triad]
            _, E, D = triads[triad]
            of = {key: one["value"] for key, one in entry["coefficients"].items()}
            match name, entry.get("shape", ""):
                case "quadratic", _:
                    added[triad] += c * v**2
                case "cubic", _:
                    added[triad] += c * v**3
                case "scale_asymmetry", _:
                    added[triad] += 0.5e-6 * c * abs(v)
                case "scale_nonlinearity", "u |u|":
                    added[triad] += 1e-6 * c * v * abs(v)
                case "scale_nonlinearity", "u^3":
                    added[triad] += 1e-6 * c * v**3
                case "sagnac_sine", _:
                    added[triad] += np.sin(c * v) / c - v
                case "cross_product", _:
                    for key, value in of.items():
                        i, j, k = ("xyz".index(letter) for letter in key)
                        added[triad][:, i] += value * v[:, j] * v[:, k]
                case "g_sensitivity", _:
                    for key, value in of.items():
                        i, j = ("xyz".index(letter) for letter in key)
                        added[triad][:, i] += value / 3600 * u["accelerometer"][:, j]
                case "bias_temperature", _:
                    for key, value in of.items():
                        axis, _, n = key.partition(".")
                        added[triad][:, "xyz".index(axis)] += per * value * warm ** int(n or 1)
                case "scale_temperature", _:
                    added[triad] += 1e-6 * c * warm[:, None] * (v @ E.T + D)
                case "temperature_rate", _:
                    added[triad] += per * c * rate[:, None]
                case "temperature_rate_lag", _:
                    added[triad] += per * c * (60 * (T - lag(t, T, of["tau_s"])) / of["tau_s"])[:, None]
                case "temperature_lag", _:
                    added[triad] += per * c * (lag(t, T, of["tau_s"]) - 25.0)[:, None]
                case "scale_temperature_lag", _:
                    added[triad] += 1e-6 * c * (lag(t, T, of["tau_s"]) - 25.0)[:, None] * (v @ E.T + D)
                case "temperature_hysteresis", "with a play":
                    added[triad] += per * c * branch(T, of["play_k"])[:, None]
                case "temperature_hysteresis", _:
                    added[triad] += per * c * way[:, None]
                case other:
                    raise AssertionError(other)
        for name, (k, E, D) in triads.items():
            u[name] = np.linalg.solve(E, (output[name] / k - D - added[name]).T).T
    return u["accelerometer"] * G0, np.radians(u["gyroscope"])


def drawn_std(
    document: dict[str, Any], rates: np.ndarray, t: np.ndarray, T: np.ndarray, *, draws: int
) -> np.ndarray:
    """Return 1 sigma (6,) of what `evaluated` gives, of calibrations drawn within their sigmas."""
    draw, parts = np.random.default_rng(2), []
    truth = np.hstack(evaluated(document, rates, t, T))
    for _ in range(draws):
        other = deepcopy(document)
        for name in ("accelerometer", "gyroscope"):
            for part in other[name].values():
                drawn = draw.normal(0, 1, np.shape(part["value"])) * part["std"]
                part["value"] = (np.array(part["value"]) + drawn).tolist()
        parts.append(np.hstack(evaluated(other, rates, t, T)) - truth)
    found: np.ndarray = np.sqrt(np.mean(np.square(parts), axis=(0, 1)))
    return found
