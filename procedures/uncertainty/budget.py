"""Every parameter with its budget: combined standard uncertainty, degrees of freedom, coverage factor, parts.

The parts are uncertain numbers of GTC (GUM Tree Calculator, Measurement Standards Laboratory of New Zealand).
Their sum has the combined uncertainty, and by Welch and Satterthwaite (JCGM 100:2008, G.4.1) the degrees of
freedom; the coverage factor is that of Student's distribution at them.
"""

from dataclasses import dataclass

import numpy as np

from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.triad_calibration import scale_unit
from procedures.uncertainty.given_values import GivenValues
from procedures.uncertainty.sources import SOURCES, SourceCell, type_of
from procedures.uncertainty.triad_variance import decompose

COVERAGE_PROBABILITY = 0.95
INFINITE_DOF_FROM = 1e6  # degrees of freedom from which on they are no different from infinitely many


@dataclass(frozen=True, slots=True)
class Contribution:
    """A source's part in a parameter: 1 sigma in the parameter's unit, type A or B, degrees of freedom."""

    source: str
    type: str
    std: float
    dof: float


@dataclass(frozen=True, slots=True)
class ParameterBudget:
    """A parameter, named as in `Solution.names`, in ``unit``; ``expanded`` is ``coverage_factor * std``."""

    name: str
    value: float
    unit: str
    std: float
    dof: float
    coverage_factor: float
    expanded: float
    contributions: tuple[Contribution, ...]


def budget(fits: CampaignFits, inputs: GivenValues = GivenValues()) -> tuple[ParameterBudget, ...]:  # noqa: B008
    """Return the budgets of k, E off its diagonal, and D of every triad that was solved."""
    counts, found = fits.campaigns[0].counts, list[ParameterBudget]()
    for triad, part in decompose(fits, inputs).items():
        for i, name in enumerate(part.vector.names):
            if name.split(".")[1] == "misalignment" and name[-1] == name[-2]:
                continue
            unit = (scale_unit(triad, counts), "1", part.vector.bias_unit)[0 if i < 3 else 1 if i < 12 else 2]
            parts = {cell: float(variance[i]) for cell, variance in part.variance.items()}
            found.append(combined_budget(name, float(part.vector.value[i]), unit, parts))
    return tuple(found)


def combined_budget(name: str, value: float, unit: str, parts: dict[SourceCell, float]) -> ParameterBudget:
    """Combine the variances of independent cells."""
    from GTC import dof, reporting, ureal  # takes half a second: only where a budget is asked for

    sources = {}
    for source in SOURCES:
        numbers = [
            ureal(0.0, np.sqrt(variance), cell.dof)
            for cell, variance in parts.items()
            if cell.source == source and variance > 0
        ]
        if numbers:
            sources[source] = sum(numbers[1:], numbers[0])
    total = sum(list(sources.values())[1:], next(iter(sources.values())))
    lines = [Contribution(s, type_of(s), float(one.u), _many(dof(one))) for s, one in sources.items()]
    std, freedom = float(total.u), _many(dof(total))
    factor = float(reporting.k_factor(freedom, round(100 * COVERAGE_PROBABILITY)))
    return ParameterBudget(name, value, unit, std, freedom, factor, factor * std, tuple(lines))


def _many(dof: float) -> float:
    return float(dof) if dof < INFINITE_DOF_FROM else float("inf")
