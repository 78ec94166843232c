"""The tables of a report: parameters with U, u and a simulated unit's truth; residuals; correlations."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from procedures.calibration.solution_values import Solution, StepResidual
from procedures.frames import TRIADS
from procedures.positions import ATTITUDES
from procedures.units import ARCSEC_PER_DEG, UG_PER_G
from station.results.parameters_by_name import KINDS, Parameter, parameters, printed_scale
from station.text import aligned, decimals, fixed

NORMAL_95 = 1.959964  # two-sided 95 % of a normal distribution


@dataclass(frozen=True, slots=True, eq=False)
class ParameterGroup:
    """Parameters of one kind, in the unit of files, each with its symbol and axis, and a remark on them.

    ``expanded`` is U by name, where there is a budget; ``truth`` a simulated unit's values. An error is not set
    against a u that is of ``noise_only``.
    """

    title: str
    remark: str
    symbols: tuple[tuple[str, str], ...]
    parameters: tuple[Parameter, ...]
    truth: Mapping[str, float]
    expanded: Mapping[str, float] = field(default_factory=dict)
    noise_only: bool = False

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Printed lines: symbol, axis, value, U, u, both ends of 95 %, unit, truth, error, error/u.

        U is empty without a budget; truth and errors are without a truth.
        """
        scale, unit = printed_scale(self.parameters[0].name, self.parameters[0].unit)
        value = np.array([one.value for one in self.parameters]) * scale
        std = np.array([one.std for one in self.parameters], dtype=np.float64) * scale
        places = [decimals(s) for s in std.tolist()]
        U = [self.expanded.get(one.name, math.nan) * scale for one in self.parameters]
        wide = [fixed(u, decimals(u)) if u > 0 else "" for u in U]

        def column(numbers: Sequence[float | None], sign: bool = False) -> list[str]:
            texts = ["" if n is None else fixed(n, p, sign) for n, p in zip(numbers, places, strict=True)]
            return aligned(texts) if any(texts) else texts

        known = [self.truth[one.name] * scale if one.name in self.truth else None for one in self.parameters]
        error = [None if t is None else v - t for v, t in zip(value.tolist(), known, strict=True)]
        in_u = [
            "" if e is None or self.noise_only or not s > 0 else fixed(e / s, 1, sign=True)
            for e, s in zip(error, std.tolist(), strict=True)
        ]
        ends = (column((value + side * NORMAL_95 * std).tolist()) for side in (-1, 1))
        columns = (
            column(value.tolist()), aligned(wide) if any(wide) else wide, column(std.tolist()), *ends,
            [unit] * len(value), column(known), column(error, sign=True), in_u,
        )  # fmt: skip
        return [(*symbol, *cells) for symbol, *cells in zip(self.symbols, *columns, strict=True)]


@dataclass(frozen=True, slots=True)
class TriadResult:
    """What a report says of ``accelerometer`` or ``gyroscope``; ``matrix`` is E with u in parentheses."""

    name: str
    groups: tuple[ParameterGroup, ...]
    matrix: list[list[str]]
    has_budget: bool


def triad_results(
    document: Mapping[str, Any], truth: Mapping[str, float], expanded: Mapping[str, float]
) -> tuple[TriadResult, ...]:
    """Return the triads of a `solution/1`; ``expanded`` are U by parameter, in the unit of files."""
    return tuple(
        TriadResult(
            triad,
            _triad_groups(triad, document, truth, expanded),
            _matrix(document[triad].get("misalignment", {"value": (), "std": ()})),
            any(name.startswith(triad) for name in expanded),
        )
        for triad in TRIADS
        if triad in document
    )


def _triad_groups(
    triad: str, document: Mapping[str, Any], truth: Mapping[str, float], expanded: Mapping[str, float]
) -> tuple[ParameterGroup, ...]:
    groups, found = list[ParameterGroup](), parameters(document)
    for kind in KINDS:
        mine = tuple(one for name, one in found.items() if name.startswith(f"{triad}.{kind.field}."))
        symbols = tuple((kind.symbol, one.name.rpartition(".")[2]) for one in mine)
        same = {name.replace(".bias.", f".{kind.field}."): value for name, value in truth.items()}
        if mine:
            known = same if kind.method else truth
            groups.append(
                ParameterGroup(kind.heading, kind.remark, symbols, mine, known, expanded, bool(kind.method))
            )
    return tuple(groups)


def bench_groups(document: Mapping[str, Any], truth: Mapping[str, float]) -> tuple[ParameterGroup, ...]:
    """Return tilt of the surface plate and parallelism of the faces."""
    found, groups = parameters(document).values(), list[ParameterGroup]()
    if tilt := tuple(one for one in found if one.name.startswith("slab.")):
        remark = "components of the up vector in the axes of the surface plate"
        symbols = tuple(("tilt", one.name.rpartition(".")[2]) for one in tilt)
        groups.append(ParameterGroup("Surface plate tilt", remark, symbols, tilt, truth))
    if faces := tuple(one for one in found if one.name.startswith("fixture.")):
        remark = "sum of the up tilts of the two faces of a pair, along the other axes"
        pairs = (one.name.split(".")[2:] for one in faces)
        symbols = tuple((f"pair {pair}", f"\u2192 {other}") for pair, other in pairs)
        groups.append(ParameterGroup("Face parallelism", remark, symbols, faces, truth))
    return tuple(groups)


def _matrix(misalignment: Mapping[str, Any]) -> list[list[str]]:
    """Return E (3, 3) with the uncertainty of its last digits in parentheses, dimensionless."""
    rows = zip(misalignment["value"], misalignment["std"], strict=True)
    return [[_with_last_digits(v, s) for v, s in zip(*row, strict=True)] for row in rows]


def _with_last_digits(value: float, std: float) -> str:
    places = decimals(std)
    digits = f"({round(std * 10.0**places)})" if std > 0 else ""
    return fixed(value, max(places, 0)) + digits


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
