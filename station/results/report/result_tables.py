"""The tables of a report: parameters with U, u and a simulated unit's truth; residuals; correlations."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.calibration.solution_values import Estimate, Solution, StepResidual, TriadCalibration
from procedures.positions import ATTITUDES
from procedures.units import ARCSEC_PER_DEG, UG_PER_G
from station.results.parameters_by_name import Parameter, parameters, printed_scale
from station.results.solution_json import estimate_document
from station.text import aligned, decimals, fixed

NORMAL_95 = 1.959964  # two-sided 95 % of a normal distribution
TEXTBOOK = "Yao, Hu, He 2018, {}; its u includes counting noise only"
TRIAD_GROUPS = (  # field of a triad, symbol, title, remark
    ("scale_factor", "K", "Scale factor K", ""),
    ("misalignment", "E", "Misalignment E", "off-diagonal; first index sensor, second body axis"),
    ("bias", "D", "Bias D", "joint estimate: use this one"),
    ("bias_12_position", "D", "Bias, 12-position mean", TEXTBOOK.format("eq. 8")),
    ("bias_two_direction", "D", "Bias, two-direction", TEXTBOOK.format("eq. 9\u201311")),
)


@dataclass(frozen=True, slots=True)
class ParameterGroup:
    """Printed lines of one kind, with a remark under their heading.

    Each has symbol, axis, value, U, u, both ends of the interval of 95 %, unit, truth, error, and that in
    sigmas. U is empty without a budget; truth and errors are without a truth.
    """

    title: str
    remark: str
    rows: tuple[tuple[str, ...], ...]


def triad_groups(
    name: str, triad: TriadCalibration, truth: Mapping[str, float], expanded: Mapping[str, float]
) -> list[ParameterGroup]:
    """Return the parameter tables of a triad (``accelerometer`` or ``gyroscope``).

    ``expanded`` are the expanded uncertainties by parameter, in the unit of files.
    """
    found = _found(name, {field: getattr(triad, field) for field, *_ in TRIAD_GROUPS})
    groups = []
    for field, symbol, title, remark in TRIAD_GROUPS:
        mine = [one for one in found if one.name.startswith(f"{name}.{field}.")]
        symbols = [(symbol, one.name.rpartition(".")[2]) for one in mine]
        if field.startswith("bias_"):
            same = {key.replace(".bias.", f".{field}."): value for key, value in truth.items()}
            groups += [_group(title, remark, symbols, mine, same, noise_only=True)] if mine else []
        else:
            groups.append(_group(title, remark, symbols, mine, truth, expanded))
    return groups


def bench_groups(solution: Solution, truth: Mapping[str, float]) -> list[ParameterGroup]:
    """Return the tables of slab tilt and face parallelism, in arcsec."""
    groups = []
    if tilt := _found("slab", {"tilt_rad": solution.slab_tilt}):
        remark = "components of the up vector in the axes of the surface plate"
        symbols = [("tilt", one.name.rpartition(".")[2]) for one in tilt]
        groups.append(_group("Surface plate tilt", remark, symbols, tilt, truth))
    if faces := _found("fixture", {"parallelism_rad": solution.parallelism}):
        remark = "sum of the up tilts of the two faces of a pair, along the other axes"
        pairs = [one.name.split(".")[2:] for one in faces]
        symbols = [(f"pair {pair}", f"\u2192 {other}") for pair, other in pairs]
        groups.append(_group("Face parallelism", remark, symbols, faces, truth))
    return groups


def matrix_rows(misalignment: Estimate) -> list[list[str]]:
    """Return E (3, 3) with the uncertainty of its last digits in parentheses, dimensionless."""
    rows = []
    for value, std in zip(misalignment.value, misalignment.std, strict=True):
        cells = []
        for v, s in zip(value, std, strict=True):
            places = decimals(float(s))
            digits = f"({round(s * 10.0**places)})" if math.isfinite(s) and s > 0 else ""
            cells.append(fixed(float(v), max(places, 0)) + digits)
        rows.append(cells)
    return rows


def _found(part: str, estimates: Mapping[str, Estimate | None]) -> list[Parameter]:
    text = {field: estimate_document(one) for field, one in estimates.items() if one is not None}
    return list(parameters({part: text}).values())


def _group(
    title: str, remark: str, symbols: Sequence[tuple[str, str]], found: Sequence[Parameter],
    truth: Mapping[str, float], expanded: Mapping[str, float] | None = None, noise_only: bool = False,
) -> ParameterGroup:  # fmt: skip
    scale, unit = printed_scale(found[0].name, found[0].unit)
    value = np.array([one.value for one in found]) * scale
    std = np.array([one.std for one in found], dtype=np.float64) * scale
    places = [decimals(s) for s in std.tolist()]
    U = [(expanded or {}).get(one.name, math.nan) * scale for one in found]
    wide = [fixed(u, decimals(u)) if u > 0 else "" for u in U]

    def column(numbers: Sequence[float | None], sign: bool = False) -> list[str]:
        texts = ["" if n is None else fixed(n, p, sign) for n, p in zip(numbers, places, strict=True)]
        return aligned(texts) if any(texts) else texts

    known = [truth[one.name] * scale if one.name in truth else None for one in found]
    error = [None if t is None else v - t for v, t in zip(value.tolist(), known, strict=True)]
    sigmas = [
        "" if e is None or noise_only or not s > 0 else fixed(e / s, 1, sign=True)
        for e, s in zip(error, std.tolist(), strict=True)
    ]
    columns = (
        column(value.tolist()),
        aligned(wide) if any(wide) else wide,
        column(std.tolist()),
        column((value - NORMAL_95 * std).tolist()),
        column((value + NORMAL_95 * std).tolist()),
        [unit] * len(found),
        column(known),
        column(error, sign=True),
        sigmas,
    )
    rows = tuple((*symbol, *cells) for symbol, *cells in zip(symbols, *columns, strict=True))
    return ParameterGroup(title, remark, rows)


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
