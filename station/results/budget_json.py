"""A unit's uncertainty budgets as `budget/1`: JSON-ready, contributions of nothing left out."""

import math
from collections.abc import Sequence
from typing import Any

from procedures.uncertainty.budget import COVERAGE_PROBABILITY, ParameterBudget

FORMAT = "budget/1"


def budget_document(budgets: Sequence[ParameterBudget]) -> dict[str, Any]:
    """Return budgets as `budget/1`: an infinite ``dof`` is left out, and a parameter that is not finite."""
    shown = [one for one in budgets if math.isfinite(one.value) and math.isfinite(one.std)]
    return {"format": FORMAT, "coverage": COVERAGE_PROBABILITY, "parameters": [_parameter(one) for one in shown]}


def _parameter(one: ParameterBudget) -> dict[str, Any]:
    return {
        "name": one.name,
        "value": one.value,
        "unit": one.unit,
        "std": one.std,
        **_dof(one.dof),
        "coverage_factor": one.coverage_factor,
        "expanded": one.expanded,
        "contributions": [
            {"source": part.source, "type": part.type, "std": part.std, **_dof(part.dof)}
            for part in one.contributions
        ],
    }


def _dof(dof: float) -> dict[str, float]:
    return {"dof": dof} if math.isfinite(dof) else {}
