"""Whether what is left goes with anything: families of curves of time, temperature, input and what was before.

The global test spreads over hundreds of rows, and six sigmas along one line drown there. A cause that is in no
catalogue is still a function of something that the sensors went through, so each such coordinate has a family of
smooth curves, and what is left is projected on each, of every sensor and of a triad's three together. With H the
family's columns in sigmas as far as the model leaves them and r what is left, ``r' H (H'H)^-1 H' r`` is chi-square
of as many degrees of freedom as H has columns. It names no cause.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.linear_model import LinearFit
from procedures.diagnosis.residual_rows import Evidence
from procedures.effects.effect import Columns, Excitation, per_axis
from procedures.effects.temperature_history import lagged
from procedures.frames import AXES, TRIADS
from procedures.statistics.least_squares import left_singular
from procedures.statistics.significance import log_chi2_sf

SLOW, FAST = (
    tuple(range(1, 6)),
    tuple(range(6, 13)),
)  # degrees of polynomials, half periods of cosines, in a campaign's time
WAVES = tuple(range(4, 20))  # half periods of cosines in a campaign's range of temperature, as of an interference
TAUS_S = (10.0, 40.0)  # of what fades after the cube was set down
WARMTH_TAUS_S = (100.0, 300.0)  # of the warmth that turning leaves
THRESHOLD = 0.1  # of the input's size, about which a dead zone or a threshold shows
NEAR_NOUGHT = (0.3, 0.6)  # of it: how wide a zone about nought is in which a sensor does otherwise
KNEES = (0.4, 0.6, 0.8)  # of the fastest rate, from which on a range ends or counts are lost
MIN_TEMPERATURE_K = 0.5
MIN_LEFT = 1e-3  # of a column's squares that the model must leave for it to be looked at
INDEPENDENT = 1e-6  # of the largest, below which a combination of columns is none of its own


@dataclass(frozen=True, slots=True, eq=False)
class Direction:
    """A family along which was looked: ``log_p`` of what is left there, and the rows' columns (n, k) in sigmas."""

    what: str
    triad: str
    log_p: float
    H: FloatArray


def worst_direction(evidence: Evidence, fit: LinearFit, triad: str = "") -> Direction | None:
    """Return the family along which a fit with unwidened sigmas leaves most, of one triad if it is named.

    ``log_p`` counts all that were looked at. None where nothing can be looked at, or where sigma is the rows' own
    scatter, which what goes along a curve has a part in.
    """
    if np.isfinite(evidence.noise_dof):
        return None
    of_triad = (each for each in families(evidence) if triad in {"", each[1]})
    squares = ((what, of, H, *_squares(fit, H)) for what, of, H in of_triad)
    found = [Direction(what, of, log_chi2_sf(r, k), H) for what, of, H, r, k in squares if k]
    if not found:
        return None
    worst = min(found, key=lambda each: each.log_p)
    return Direction(worst.what, worst.triad, min(worst.log_p + float(np.log(len(found))), 0.0), worst.H)


def excess_along(fit: LinearFit, H: FloatArray) -> float:
    """Return by how much the squares of what is left along columns (n, k), in sigmas, exceed noise; at least 0."""
    squares, k = _squares(fit, H)
    return max(squares - k, 0.0)


def _squares(fit: LinearFit, H: FloatArray) -> tuple[float, int]:
    """Return the sum of squares of what is left along columns (n, k), and how many of them the model leaves."""
    wide = np.zeros((len(fit.whole), H.shape[1]))
    wide[: len(H)] = H
    size = np.linalg.norm(wide, axis=0)
    left = wide - fit.Q @ (fit.Q.T @ wide)
    kept = (size > 0) & (np.sum(left**2, axis=0) > MIN_LEFT * size**2)
    if not kept.any():
        return 0.0, 0
    U, s = left_singular(left[:, kept] / size[kept])
    U = U[:, s**2 > INDEPENDENT * s[0] ** 2]
    return float(np.sum((U.T @ fit.whole) ** 2)), U.shape[1]


@lru_cache(maxsize=4)
def families(evidence: Evidence) -> tuple[tuple[str, str, FloatArray], ...]:
    """Return each family's name, triad and columns (n, k) in sigmas: of the three sensors, and of each alone."""
    return tuple(_families(evidence))


def _families(evidence: Evidence) -> Iterator[tuple[str, str, FloatArray]]:
    seen = evidence.excitation
    for number, triad in enumerate(TRIADS):
        output = (seen.accel_output, seen.gyro_output)[number]
        for what, curves in _curves(seen, output, triad):
            known = [np.nan_to_num(curve) for curve in curves if np.isfinite(curve).any()]
            if not known:
                continue
            values = np.concatenate([per_axis(each) for each in known], axis=2)
            names = tuple(str(i) for i in range(values.shape[2]))
            columns = Columns(names, accel=values) if number == 0 else Columns(names, gyro=values)
            H = evidence.column(columns) / evidence.sigma[:, None]
            yield what, triad, H
            yield from ((f"{what}, {name}", triad, H[:, i::3]) for i, name in enumerate(AXES))


def _curves(seen: Excitation, output: FloatArray, triad: str) -> Iterator[tuple[str, list[FloatArray]]]:
    """Yield families of curves, each (n,) or (n, 3) by sensor at the nodes of all steps."""
    kind = np.array([step.kind for step in seen.steps])[seen.step]
    turning, resting = np.isin(kind, ("turn", "move")), np.isin(kind, ("dwell", "rest", "soak"))
    x, history = time_in_history(seen), seen.histories[seen.step]
    yield "slow time", [np.polynomial.legendre.Legendre.basis(k)(x) for k in SLOW]
    yield "time", [np.cos(np.pi * k * (x + 1) / 2) for k in FAST]
    T = seen.temperature
    if np.isfinite(T).any() and np.nanmax(T) - np.nanmin(T) > MIN_TEMPERATURE_K:
        at = (T - np.nanmean(T)) / max(float(np.nanstd(T)), 1e-9)
        yield "temperature", [at, at**2, at**3, seen.temperature_rate]
        part = (T - np.nanmin(T)) / (np.nanmax(T) - np.nanmin(T))
        yield "waves of temperature", [np.cos(np.pi * k * part) for k in WAVES]
    yield "specific force", [seen.f[:, i] * seen.f[:, j] for i in range(3) for j in range(i, 3)]
    first = [resting & np.isnan(seen.change[:, 0]) & (history == one) for one in np.unique(history)]
    # before the first step nobody knows how it stood: what that left is a constant of its own
    yield "the position before", [seen.f_before[:, i] * resting for i in range(3)] + [1.0 * each for each in first]
    fading = [np.where(resting, np.exp(-seen.rest_s / tau), 0.0)[:, None] for tau in TAUS_S]
    yield "time at rest", [each * by for each in fading for by in (1 + 0 * seen.f, seen.change, seen.f**2)]
    yield "scale factor by time", [np.polynomial.legendre.Legendre.basis(k)(x)[:, None] * output for k in SLOW[:3]]
    size = max(float(np.median(np.abs(output[resting]))), 1e-12) if resting.any() else 1.0
    u = np.where(resting[:, None], output / size, 0.0)
    yield "input at rest", [u**2, np.abs(u), u**3, np.tanh(u / THRESHOLD)]
    zones = [np.where(resting[:, None], np.exp(-((u / w) ** 2)), 0.0) for w in NEAR_NOUGHT]
    yield "input near zero", [each * by for each in zones for by in (1 + 0 * u, u)]
    if np.isfinite(seen.magnetic).any():
        yield "magnetic field", [seen.magnetic[:, i] for i in range(3)]
    if triad == "gyroscope" and turning.any():
        u = np.where(turning[:, None], output / max(float(np.abs(output[turning]).max()), 1e-12), 0.0)
        around = [np.roll(u, shift, axis=1) ** 2 for shift in (1, 2)]
        yield "rate", [np.abs(u), u * np.abs(u), u**3, *around]
        yield "heating by rotation", [warmth_of_turning(seen, turning, tau) for tau in WARMTH_TAUS_S]
        yield "fast rate", [np.sign(u) * np.maximum(np.abs(u) - knee, 0.0) for knee in KNEES]


def warmth_of_turning(seen: Excitation, turning: BoolArray, tau_s: float) -> FloatArray:
    """Return what turning has warmed (n,), which follows the square of the rate, of any unit."""
    power, history = np.where(turning, np.sum(seen.omega**2, axis=1), 0.0), seen.histories[seen.step]
    found = np.zeros(len(seen.t))
    for one in np.unique(history):
        order = np.flatnonzero(history == one)
        order = order[np.argsort(seen.t[order], kind="stable")]
        found[order] = lagged(seen.t[order], power[order], tau_s)
    return found


def time_in_history(seen: Excitation) -> FloatArray:
    """Return time (n,) from -1 to 1 within each history."""
    history, x = seen.histories[seen.step], np.zeros(len(seen.t))
    for one in np.unique(history):
        here = history == one
        t = seen.t[here]
        x[here] = 2 * (t - t.min()) / max(float(np.ptp(t)), 1e-9) - 1
    return x
