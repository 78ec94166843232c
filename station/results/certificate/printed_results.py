"""The results as a certificate prints them: value and expanded uncertainty U, coverage factor, degrees of freedom.

U has two significant digits and the value the same last place (JCGM 100:2008, 7.2.6).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from procedures.frames import TRIADS
from station.results.parameters_by_name import Parameter, applied, parameters, shown_scale
from station.text.rounding import aligned, decimals, fixed

INFINITE = "\u221e"
UNITS = {"ug": "\u00b5g", "count/(g s)": "count/(g\u00b7s)"}
_GROUPS = {
    "scale_factor": ("k", "Scale factor k", ""),
    "misalignment": ("E", "Misalignment E", "off-diagonal, as an angle; first index sensor, second body axis"),
    "bias": ("D", "Bias D", ""),
}
_MAX_CONTRIBUTIONS = 3


@dataclass(frozen=True, slots=True)
class MeasuredParameter:
    """A result: the value applied, its combined standard uncertainty, and what the budget says beside it.

    In the unit of files; ``dof`` is infinite where the budget leaves it out, ``expanded`` is U = k u.
    """

    parameter: Parameter
    std: float
    dof: float
    coverage_factor: float
    expanded: float
    contributions: tuple[Mapping[str, Any], ...]


@dataclass(frozen=True, slots=True)
class ResultRow:
    """A printed line of the results; ``parts`` says what makes up most of the variance."""

    symbol: str
    axis: str
    value: str
    expanded: str
    coverage_factor: str
    dof: str
    unit: str
    parts: str


@dataclass(frozen=True, slots=True)
class ResultGroup:
    """Rows of one kind of one triad."""

    triad: str
    title: str
    remark: str
    rows: tuple[ResultRow, ...]


def measured(document: Mapping[str, Any]) -> dict[str, MeasuredParameter]:
    """Return the results of a calibration/1 by name; without a budget/1 in it, none."""
    budget = {one["name"]: one for one in document.get("uncertainty", {}).get("parameters", ())}
    return {
        name: MeasuredParameter(
            parameter,
            one["std"],
            one.get("dof", math.inf),
            one["coverage_factor"],
            one["expanded"],
            tuple(one.get("contributions", ())),
        )
        for name, parameter in applied(parameters(document)).items()
        if (one := budget.get(name)) is not None
    }


def result_groups(results: Mapping[str, MeasuredParameter]) -> list[ResultGroup]:
    """Return the tables of results, triad by triad."""
    groups = []
    for triad in TRIADS:
        for part, (symbol, title, remark) in _GROUPS.items():
            mine = [one for name, one in results.items() if name.startswith(f"{triad}.{part}.")]
            if mine:
                groups.append(ResultGroup(triad, title, remark, _rows(symbol, mine)))
    return groups


def unit_of(parameter: Parameter) -> tuple[float, str]:
    """Return by what a value is multiplied for print, and the unit it then has."""
    scale, unit = shown_scale(parameter.name, parameter.unit)
    return scale, UNITS.get(unit, unit)


def axis_of(name: str) -> str:
    """Return the axis or axes that a parameter's name ends in."""
    return name.rpartition(".")[2]


def to_two_digits(values: Sequence[float], by: Sequence[float]) -> list[str]:
    """Return values to the place of two significant digits of ``by``, their points below each other."""
    return aligned([fixed(value, decimals(each)) for value, each in zip(values, by, strict=True)])


def _rows(symbol: str, results: Sequence[MeasuredParameter]) -> tuple[ResultRow, ...]:
    scale, unit = unit_of(results[0].parameter)
    expanded = [one.expanded * scale for one in results]
    columns = zip(
        to_two_digits([one.parameter.value * scale for one in results], expanded),
        to_two_digits(expanded, expanded),
        strict=True,
    )
    return tuple(
        ResultRow(
            symbol,
            axis_of(one.parameter.name),
            value,
            uncertainty,
            fixed(one.coverage_factor, 2),
            degrees(one.dof),
            unit,
            main_parts(one.contributions),
        )
        for one, (value, uncertainty) in zip(results, columns, strict=True)
    )


def degrees(dof: float) -> str:
    """Return effective degrees of freedom as printed, rounded down (JCGM 100:2008, G.4.1)."""
    return INFINITE if math.isinf(dof) or dof >= 1e4 else f"{math.floor(dof)}"


def main_parts(contributions: Sequence[Mapping[str, Any]]) -> str:
    """Return the greatest parts of a budget with their share of the variance."""
    total = sum(part["std"] ** 2 for part in contributions)
    if not total > 0:
        return ""
    greatest = sorted(contributions, key=lambda part: -part["std"])[:_MAX_CONTRIBUTIONS]
    shares = [(part["source"], 100 * part["std"] ** 2 / total) for part in greatest]
    return ", ".join(f"{source}\u00a0{share:.0f}\u00a0%" for source, share in shares if share >= 1)
