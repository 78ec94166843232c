"""Where what the model leaves shows most: kinds of rows, steps, temperature, time.

Each test is against counting noise, or of the rows' scatter about a parabola; the least p of a kind counts as one
of as many as were looked at. It names no cause: it says where to look for one.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.evidence.linear_model import LinearFit, variance_classes
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import TRIADS
from procedures.statistics.significance import log_chi2_sf, log_f_sf
from procedures.uncertainty.sources import Unexplained

MAX_LOG_P = np.log(0.01)
MAX_STEPS = 3
MIN_FREE = 1.0  # degrees of freedom of rows worth testing
DEGREE = 2  # of the polynomial in temperature or time
MIN_POINTS = DEGREE + 4

By = Literal["rows", "step", "temperature", "time"]


@dataclass(frozen=True, slots=True)
class LeftPattern:
    """What is left by ``rows`` (``what``: triad, kind), ``step`` (name), ``temperature`` or ``time`` (sensor).

    ``size`` is the rms over that of noise, by temperature and time the share (0 to 1) of the rows' squares that a
    parabola takes; ``log_p`` counts all that were looked at.
    """

    by: By
    what: str
    size: float
    log_p: float


def left_patterns(evidence: Evidence, fit: LinearFit) -> tuple[LeftPattern, ...]:
    """Return where what a fit with unwidened sigmas leaves shows, the surest of each kind first."""
    nodes, seen = evidence.excitation.step, evidence.excitation
    return (
        *_surest(list(_by_rows(evidence, fit))),
        *_surest(list(_by_step(evidence, fit)))[:MAX_STEPS],
        *_surest(list(_along("temperature", evidence, fit, _mean_by_step(seen.temperature, nodes)))),
        *_surest(list(_along("time", evidence, fit, _mean_by_step(seen.t, nodes)))),
    )


def _surest(found: list[LeftPattern]) -> list[LeftPattern]:
    counted = [LeftPattern(one.by, one.what, one.size, min(one.log_p + np.log(len(found)), 0.0)) for one in found]
    return sorted((one for one in counted if one.log_p < MAX_LOG_P), key=lambda one: one.log_p)


def _squares(fit: LinearFit, rows: BoolArray) -> tuple[float, float]:
    return float(np.sum(fit.white[rows] ** 2)), float(np.sum((1 - fit.leverage)[rows]))


def _by_rows(evidence: Evidence, fit: LinearFit) -> Iterator[LeftPattern]:
    for triad in TRIADS:
        for kind in KINDS:
            squares, free = _squares(fit, evidence.rows(kind, triad=triad) & evidence.is_data)
            if free >= MIN_FREE:
                size = float(np.sqrt(squares / free))
                yield LeftPattern("rows", f"{triad} {kind}", size, log_chi2_sf(squares, max(round(free), 1)))


def _by_step(evidence: Evidence, fit: LinearFit) -> Iterator[LeftPattern]:
    for number, step in enumerate(evidence.excitation.steps):
        squares, free = _squares(fit, (evidence.step == number) & ~evidence.rows("level"))
        if free >= MIN_FREE:
            size = float(np.sqrt(squares / free))
            yield LeftPattern("step", step.name, size, log_chi2_sf(squares, max(round(free), 1)))


def _mean_by_step(values: FloatArray, step: np.ndarray) -> Callable[[int], float]:
    return lambda number: float(np.mean(values[step == number]))


def _along(by: By, evidence: Evidence, fit: LinearFit, at: Callable[[int], float]) -> Iterator[LeftPattern]:
    """Yield of each sensor how much of its means' squares goes with a parabola of a coordinate of the steps."""
    where = np.array([at(number) for number in range(len(evidence.excitation.steps))])
    for triad in TRIADS:
        for axis in range(3):
            rows = evidence.rows("mean", "soak", triad=triad) & (evidence.axis == axis)
            x, y = where[evidence.step[rows]], fit.white[rows]
            if len(y) < MIN_POINTS or not np.all(np.isfinite(x)) or np.ptp(x) == 0 or not y.any():
                continue
            V = np.linalg.qr(np.vander((x - x.mean()) / np.ptp(x), DEGREE + 1))[0]
            whole = float(np.sum((y - y.mean()) ** 2))
            left = float(np.sum((y - V @ (V.T @ y)) ** 2))
            free = len(y) - DEGREE - 1
            ratio = ((whole - left) / DEGREE) / max(left / free, np.finfo(float).tiny)
            yield LeftPattern(by, f"{triad} {'xyz'[axis]}", 1 - left / whole, log_f_sf(ratio, DEGREE, free))


MIN_ROW_FREEDOM = 0.02  # a row of which the fit leaves less is the fit's, not the data's
SHAPES = ("slope", "curvature")
MIN_CLASS_DOF = 2.0  # degrees of freedom of a class worth testing


def global_log_p(evidence: Evidence, fit: LinearFit) -> float:
    """Return ln p of what a fit with unwidened sigmas leaves."""
    shared, free = variance_classes(evidence), 1 - fit.leverage
    counted = (evidence.kind != KINDS.index("prior")) | ~evidence.is_range
    found = list[float]()
    for number in np.unique(shared[counted]):
        rows = counted & (shared == number)
        dof = float(free[rows].sum())
        clear = rows & (free > MIN_ROW_FREEDOM)
        if dof < MIN_CLASS_DOF or not clear.any():
            continue
        k = max(round(dof), 1)
        found.append(log_f_sf(float(np.sum(fit.white[rows] ** 2)) / k, k, evidence.noise_dof))
        worst = float(np.max(fit.white[clear] ** 2 / free[clear]))
        found.append(log_f_sf(worst, 1, evidence.noise_dof) + np.log(clear.sum()))
    return min(min(found) + np.log(len(found)), 0.0) if found else 0.0


def within_dwells(evidence: Evidence, fit: LinearFit) -> dict[str, Unexplained]:
    """Return by triad the variance of the drift within its dwells, in squares of the mean's counting noise.

    ``fit`` is the last, with unwidened sigmas. Scatter of means, turns and norms widens its sigmas; slope and
    curvature within a dwell are no rows of a calibration's fit. White noise gives a slope as much as it gives the
    mean (a ramp's rms over a dwell, in sigmas of the mean, is its slope in sigmas of the slope), so by as many
    squares of its sigma as the shapes have too many, the mean is off as well.
    """
    found = dict[str, Unexplained]()
    for triad in TRIADS:
        rows = evidence.rows(*SHAPES, triad=triad)
        free = float(np.sum((1 - fit.leverage)[rows]))
        if free > 0:
            found[triad] = Unexplained(max(float(np.sum(fit.white[rows] ** 2)) / free - 1, 0.0))
    return found
