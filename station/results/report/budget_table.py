"""The table of uncertainty budgets: value, expanded uncertainty, coverage factor, and what contributes most."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from procedures.uncertainty.budget import Contribution, ParameterBudget
from procedures.units import ARCSEC_PER_RAD, UG_PER_G
from station.results.report.parameter_tables import SYMBOLS
from station.text.rounding import aligned, decimals, fixed

MAX_CONTRIBUTIONS_SHOWN = 3  # contributions a line
MODEL_LETTERS = {"scale_factor": "k", "misalignment": "E", "bias": "D"}
INFINITE = "\u221e"


@dataclass(frozen=True, slots=True)
class BudgetRow:
    """A printed line; ``contributions`` are the largest, each with its share of the variance."""

    letter: str
    axis: str
    value: str
    expanded: str
    unit: str
    factor: str
    dof: str
    contributions: str


@dataclass(frozen=True, slots=True)
class BudgetTable:
    """A triad's lines."""

    triad: str
    rows: tuple[BudgetRow, ...]


def budget_tables(budgets: Sequence[ParameterBudget]) -> list[BudgetTable]:
    """Return a table per triad, none where there is no budget."""
    triads = dict.fromkeys(one.name.split(".")[0] for one in budgets)
    return [
        BudgetTable(triad, tuple(_rows([one for one in budgets if one.name.split(".")[0] == triad])))
        for triad in triads
    ]


def _rows(budgets: Sequence[ParameterBudget]) -> list[BudgetRow]:
    scaled = [_shown(one) for one in budgets]
    places = [decimals(one.expanded * scale) for one, (scale, _) in zip(budgets, scaled, strict=True)]
    each = list(zip(budgets, scaled, places, strict=True))
    value = aligned([fixed(one.value * scale, p) for one, (scale, _), p in each])
    expanded = aligned([fixed(one.expanded * scale, p) for one, (scale, _), p in each])
    return [
        BudgetRow(
            MODEL_LETTERS[one.name.split(".")[1]], one.name.split(".")[2], v, u, unit,
            f"{one.coverage_factor:.2f}", dof_text(one.dof), largest(one),
        )
        for one, (_, unit), v, u in zip(budgets, scaled, value, expanded, strict=True)
    ]  # fmt: skip


def _shown(one: ParameterBudget) -> tuple[float, str]:
    if one.unit == "1":
        return ARCSEC_PER_RAD, "arcsec"
    return (UG_PER_G, "\u00b5g") if one.unit == "g" else (1.0, SYMBOLS.get(one.unit, one.unit))


def dof_text(dof: float) -> str:
    """Return degrees of freedom rounded down (JCGM 100:2008, G.6.4), or the sign for infinitely many."""
    return str(math.floor(dof)) if math.isfinite(dof) else INFINITE


def largest(one: ParameterBudget) -> str:
    """Return the sources that make up most of a parameter's variance, largest first, with their share."""
    parts = sorted(one.contributions, key=lambda part: part.std, reverse=True)[:MAX_CONTRIBUTIONS_SHOWN]
    return ", ".join(f"{part.source} {_share(part, one)}" for part in parts if part.std > 0)


def _share(part: Contribution, one: ParameterBudget) -> str:
    percent = 100 * (part.std / one.std) ** 2
    return f"{percent:.0f} %" if percent >= 1 else "< 1 %"
