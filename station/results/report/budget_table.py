"""The table of uncertainty budgets: value, expanded uncertainty, coverage factor, and what contributes most."""

import math
from collections.abc import Sequence

from procedures.uncertainty.budget import Contribution, ParameterBudget
from station.results.certificate.printed_results import INFINITE, MAX_CONTRIBUTIONS, Row, budget_rows


def budget_tables(budgets: Sequence[ParameterBudget]) -> list[tuple[str, list[Row]]]:
    """Return triad and printed lines of each triad that has a budget."""
    triads = dict.fromkeys(one.name.split(".")[0] for one in budgets)
    mine = {triad: [one for one in budgets if one.name.split(".")[0] == triad] for triad in triads}
    return [(triad, budget_rows(found, dof_text, largest)) for triad, found in mine.items()]


def dof_text(dof: float) -> str:
    """Return degrees of freedom rounded down (JCGM 100:2008, G.6.4), or the sign for infinitely many."""
    return str(math.floor(dof)) if math.isfinite(dof) else INFINITE


def largest(one: ParameterBudget) -> str:
    """Return the sources that make up most of a parameter's variance, largest first, with their share."""
    parts = sorted(one.contributions, key=lambda part: part.std, reverse=True)[:MAX_CONTRIBUTIONS]
    return ", ".join(f"{part.source} {_share(part, one)}" for part in parts if part.std > 0)


def _share(part: Contribution, one: ParameterBudget) -> str:
    percent = 100 * (part.std / one.std) ** 2
    return f"{percent:.0f} %" if percent >= 1 else "< 1 %"
