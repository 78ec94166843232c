"""A base model of some steps, which can be solved again with effects in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from procedures.calibration.joint_calibration import CampaignFits, report
from procedures.calibration.reduced_steps import ReducedSteps
from procedures.calibration.solution_values import Solution
from procedures.evidence.candidates import Candidate
from procedures.evidence.refit import Refit, refit
from procedures.inference.result import TableSensor


@dataclass(frozen=True, slots=True, eq=False)
class BenchModel:
    """Dwells, turns and rests, reduced to rates and totals, and the fits to them without effects."""

    steps: ReducedSteps
    base: CampaignFits

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Solve both triads again."""
        return refit(self.steps, self.base, added)

    def report(self, found: Refit) -> Solution:
        """Return both triads' solution."""
        return report(found.fits)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: the bench is no table."""
        return ()


class BaseModel(Protocol):
    """A base model with the data it is fitted to: `BenchModel`, one with declared effects, rate tables, soaks."""

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Solve with effects ``added``."""
        ...

    def report(self, found: Refit) -> Solution:
        """Return what a refit solved."""
        ...

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return the gyroscopes that a rate table turned."""
        ...
