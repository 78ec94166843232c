"""How well the model fits: residual of every step against its limit, and the correlations that matter."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.calibration.solution_values import Solution, StepResidual
from procedures.frames import ATTITUDES
from procedures.units import ARCSEC_PER_DEG, UG_PER_G
from station.text import aligned, decimals, fixed

LIMIT_SIGMAS = 4.0
NOTICE_SIGMAS = 2.0
MIN_CORRELATION_SHOWN = 0.5
MAX_CORRELATIONS_SHOWN = 16
_DISPLAY_UNITS = {"g": (UG_PER_G, "\u00b5g"), "deg/h": (1.0, "deg/h"), "deg": (ARCSEC_PER_DEG, "arcsec")}


ResidualRow = tuple[str, str, tuple[str, ...], str, str]


@dataclass(frozen=True, slots=True)
class ResidualTable:
    """The residuals of one triad and kind of step, in ``unit``.

    Of each step its name, position, residual and limit by axis, the greatest ratio to sigma, and its mark.
    """

    triad: str
    kind: str
    unit: str
    rows: list[ResidualRow]


def normalised(residual: StepResidual) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return residual / sigma (3,), nan where there is no sigma."""
    ratio = np.full(3, np.nan)
    np.divide(residual.residual, residual.sigma, out=ratio, where=np.asarray(residual.sigma) > 0)
    return ratio


def residual_tables(residuals: Sequence[StepResidual]) -> list[ResidualTable]:
    """Return the residuals as tables: accelerometer dwells, gyroscope dwells, turns."""
    tables = []
    for triad, kind in dict.fromkeys((r.triad, r.kind) for r in residuals):
        chosen = [r for r in residuals if (r.triad, r.kind) == (triad, kind)]
        scale, unit = _DISPLAY_UNITS.get(chosen[0].unit, (1.0, chosen[0].unit))
        tables.append(ResidualTable(triad, kind, unit, _rows(chosen, scale)))
    return tables


def correlations(solution: Solution) -> list[tuple[str, str, str, float]]:
    """Return pairs of parameters whose errors correlate by `MIN_CORRELATION_SHOWN` or more, largest first.

    Each with the correlation as text, and its magnitude.
    """
    std = np.sqrt(np.diag(solution.covariance))
    usable = np.flatnonzero(std > 0)
    matrix = solution.covariance[np.ix_(usable, usable)] / np.outer(std[usable], std[usable])
    first, second = np.triu_indices(len(usable), 1)
    value = matrix[first, second]
    shown = np.flatnonzero(np.abs(value) >= MIN_CORRELATION_SHOWN)
    order = shown[np.argsort(-np.abs(value[shown]), kind="stable")][:MAX_CORRELATIONS_SHOWN]
    names = [solution.names[i] for i in usable]
    return [
        (names[first[i]], names[second[i]], fixed(float(value[i]), 3, sign=True), float(abs(value[i])))
        for i in order
    ]


def _rows(residuals: Sequence[StepResidual], scale: float) -> list[ResidualRow]:
    columns = []
    for axis in range(3):
        values = [r.residual[axis] * scale for r in residuals]
        limits = [LIMIT_SIGMAS * r.sigma[axis] * scale for r in residuals]
        places = [decimals(r.sigma[axis] * scale) for r in residuals]
        columns.append(aligned([fixed(float(v), p, sign=True) for v, p in zip(values, places, strict=True)]))
        columns.append(aligned([fixed(float(v), p) for v, p in zip(limits, places, strict=True)]))
    return [
        (r.name, _where(r), cells, *_worst(r))
        for r, cells in zip(residuals, zip(*columns, strict=True), strict=True)
    ]


def _where(residual: StepResidual) -> str:
    known = 1 <= residual.position <= len(ATTITUDES)
    return f"{residual.position} {ATTITUDES[residual.position - 1]}" if known else "\u2013"


def _worst(residual: StepResidual) -> tuple[str, str]:
    ratio = np.abs(normalised(residual))
    if np.isnan(ratio).all():
        return "\u2013", ""
    worst = float(np.nanmax(ratio))
    mark = (
        "\u25b2 above the limit"
        if worst > LIMIT_SIGMAS
        else "\u25b3 above 2\u03c3"
        if worst > NOTICE_SIGMAS
        else ""
    )
    return fixed(worst, 1), mark
