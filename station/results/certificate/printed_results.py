"""The results as a certificate or a report prints them: value, U, k, degrees of freedom, sources of u.

U has two significant digits and the value the same last place (JCGM 100:2008, 7.2.6).
docs/explanation/uncertainty.md explains how each source is found.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from procedures.frames import TRIADS
from procedures.uncertainty import sources
from station.results.parameters_by_name import KINDS, ParameterKind, applied, parameters, printed_scale
from station.text import aligned, decimals, fixed

INFINITE = "\u221e"
MAX_CONTRIBUTIONS = 3  # of a line
Row = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MeasuredParameter:
    """A result: the value applied, its combined standard uncertainty, and what the budget states with it.

    In the unit of files; ``dof`` is infinite where the budget leaves it out, ``expanded`` is U = k u.
    """

    name: str
    value: float
    unit: str
    std: float
    dof: float
    coverage_factor: float
    expanded: float
    contributions: tuple[Mapping[str, Any], ...]


def measured(document: Mapping[str, Any]) -> dict[str, MeasuredParameter]:
    """Return the results of a calibration/1 by name; without a budget/1 in it, none."""
    budget = {one["name"]: one for one in document.get("uncertainty", {}).get("parameters", ())}
    return {
        name: MeasuredParameter(
            name, parameter.value, parameter.unit, one["std"], one.get("dof", math.inf),
            one["coverage_factor"], one["expanded"], tuple(one.get("contributions", ())),
        )
        for name, parameter in applied(parameters(document)).items()
        if (one := budget.get(name)) is not None
    }  # fmt: skip


def result_groups(results: Mapping[str, MeasuredParameter]) -> list[tuple[str, ParameterKind, list[Row]]]:
    """Return triad, kind and printed lines of the tables of results, triad by triad.

    A line has symbol, axis, value, U, coverage factor, degrees of freedom, unit, main parts and u.
    """
    return [
        (triad, kind, _rows(kind, mine))
        for triad in TRIADS
        for kind in KINDS
        if (mine := [one for name, one in results.items() if name.startswith(f"{triad}.{kind.field}.")])
    ]


def _rows(kind: ParameterKind, results: Sequence[MeasuredParameter]) -> list[Row]:
    columns = (printed_column(results, *pair) for pair in (("value", "expanded"), ("expanded",) * 2, ("std",) * 2))
    return [
        (kind.symbol, one.name.rpartition(".")[2], value, U, fixed(one.coverage_factor, 2), degrees(one.dof),
         printed_scale(one.name, one.unit)[1], main_parts(one), u)
        for one, value, U, u in zip(results, *columns, strict=True)
    ]  # fmt: skip


def printed_column(results: Sequence[Any], what: str, by: str) -> list[str]:
    """Return an attribute of results with ``name`` and ``unit`` as printed, to two digits of another, ``by``."""
    scales = [printed_scale(one.name, one.unit)[0] for one in results]
    values, sizes = (
        [getattr(one, which) * scale for one, scale in zip(results, scales, strict=True)] for which in (what, by)
    )
    return aligned([fixed(value, decimals(each)) for value, each in zip(values, sizes, strict=True)])


def degrees(dof: float) -> str:
    """Return effective degrees of freedom as printed, rounded down (JCGM 100:2008, G.4.1)."""
    return INFINITE if math.isinf(dof) or dof >= 1e4 else f"{math.floor(dof)}"


def main_parts(result: MeasuredParameter) -> str:
    """Return the greatest parts of a budget with their share of the variance."""
    return ", ".join(f"{source}\u00a0{share:.0f}\u00a0%" for source, share in main_shares(result))


def main_shares(result: MeasuredParameter) -> list[tuple[str, float]]:
    """Return source and share of the variance in percent of the greatest parts of a budget."""
    total = sum(part["std"] ** 2 for part in result.contributions)
    if not total > 0:
        return []
    greatest = sorted(result.contributions, key=lambda part: -part["std"])[:MAX_CONTRIBUTIONS]
    shares = [(part["source"], 100 * part["std"] ** 2 / total) for part in greatest]
    return [(source, share) for source, share in shares if share >= 1]


MEANINGS = {
    sources.COUNTING: "the white noise of the unit\u2019s output",
    sources.QUANTISATION: "the size of one count",
    sources.INSTABILITY: "bias instability during the measurement",
    sources.REST_SCATTER: "differences between repeated positions beyond noise",
    sources.MOVE_SCATTER: "differences between manual transfers beyond noise",
    sources.CONING: "rotation between two samples",
    sources.WARM_UP: "remaining warm-up drift after power-on",
    sources.TURN_ON: "bias differences between power-ons",
    sources.CUBE: "the angles of the cube\u2019s faces",
    sources.SLAB: "the level of the surface plate",
    sources.HEADING: "the heading in which the cube was set down",
    sources.SEAT: "the seating of the cube on the surface plate, different at each placement",
    sources.CLOSURE: "the closure error of a manual rotation",
    sources.GRAVITY: "the local gravity",
    sources.SECOND_ORDER: "second-order terms of misalignment and tilts",
    sources.FRAME: "the reference axes of free positions",
    sources.LATITUDE: "the latitude",
    sources.CLOCK: "the unit\u2019s clock",
    sources.TEMPERATURE: "the temperature dependence of the results",
    sources.EFFECTS: "the uncertainty of the error terms added to the model",
    sources.UNEXPLAINED: "the part of the residuals that no known error term explains",
}


def sources_in_words(results: Iterable[MeasuredParameter]) -> list[tuple[str, str]]:
    """Return each source that is printed among the main parts of the variance, with what it is."""
    found = {source for result in results for source, _ in main_shares(result)}
    return [(source, meaning) for source, meaning in MEANINGS.items() if source in found]
