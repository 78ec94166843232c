"""What effects are added to: a base model of some steps, which can be solved again with effects in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from procedures.calibration.calibration import Fits, Reduced, report
from procedures.calibration.solution import Solution
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.refit import Refit, refit
from procedures.diagnosis.result import TableSensor


class Subject(Protocol):
    """A base model with the data it is fitted to."""

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Solve again with effects in the model."""
        ...

    def report(self, found: Refit) -> Solution:
        """Return what was solved."""
        ...

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return the gyroscopes that rate tables turned."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """Dwells, turns and rests, reduced to rates and totals, and the fits to them without effects."""

    steps: Reduced
    base: Fits

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Solve both triads again."""
        return refit(self.steps, self.base, added)

    def report(self, found: Refit) -> Solution:
        """Return both triads' solution."""
        return report(found.fits)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: the bench is no table."""
        return ()
