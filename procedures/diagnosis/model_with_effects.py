"""A base model of some steps, which can be solved again with effects in it, and where that loop stands."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from procedures.calibration.joint_calibration import CampaignFits, report
from procedures.calibration.reduced_steps import ReducedSteps
from procedures.calibration.solution_values import Solution
from procedures.diagnosis.candidates import Candidate, Candidates
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.linear_model import Term
from procedures.diagnosis.refit import Refit, refit, terms_at
from procedures.diagnosis.result import TableSensor
from procedures.diagnosis.scatter import fitted_scatter
from procedures.effects.effect import Effect


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


@dataclass(frozen=True, eq=False)
class LoopState:
    """Where the loop stands; ``others`` are what could take an effect's place, as far as that was asked."""

    subject: BaseModel
    effects: Sequence[Effect]
    adopted: tuple[AdoptedEffect, ...]
    now: Refit
    pool: Candidates
    others: dict[Candidate, list[Candidate]] = field(default_factory=dict, init=False)

    def beside(self, but: Candidate | None = None) -> list[Term]:
        """Return the terms added to the model, but for one."""
        return [each.term for each in self.adopted if not each.candidate.is_of_model and each.candidate is not but]

    def solved_with(self, adopted: Sequence[AdoptedEffect]) -> "LoopState":
        """Solve with other effects adopted."""
        return solve_with(self.subject, adopted, self.effects)


def solve_with(subject: BaseModel, adopted: Sequence[AdoptedEffect], effects: Sequence[Effect]) -> LoopState:
    """Solve with what was adopted and look again at everything from there."""
    now = subject.refit([each.candidate for each in adopted])
    pool = Candidates(now.evidence, now.fits, effects)
    new = iter(now.added)
    again = [_found_again(each, None if each.candidate.is_of_model else next(new), pool) for each in adopted]
    found = _sized_again(again, now)
    return LoopState(subject, effects, tuple(_bent(found, now)), now, pool)


def _sized_again(adopted: Sequence[AdoptedEffect], now: Refit) -> list[AdoptedEffect]:
    """Return the effects, scatters with the size that they have beside the others."""
    found = list(adopted)
    for i, each in enumerate(found):
        others = [a.term for a in found if a is not each and not a.candidate.is_of_model]
        if each.candidate.effect.is_scatter and (sized := fitted_scatter(now.evidence, each.candidate, others)):
            found[i] = replace(each, candidate=sized.candidate)
    return found


def _bent(adopted: Sequence[AdoptedEffect], now: Refit) -> Iterator[AdoptedEffect]:
    """Yield effects that are not linear with their columns at the coefficients found."""
    values = iter(now.values)
    for each in adopted:
        candidate = each.candidate
        value = None if candidate.is_of_model else next(values)
        if value is not None and candidate.effect.added is not None:
            (term,), _ = terms_at(now.evidence, [candidate], [value])
            each = replace(each, candidate=replace(candidate, term=term))
        yield each


def _found_again(adopted: AdoptedEffect, new: Candidate | None, pool: Candidates) -> AdoptedEffect:
    """Return an adopted effect with its columns where the model now stands, ``new`` where it fits its own."""
    old = adopted.candidate
    if new is not None and old.effect.at is not None:
        return replace(adopted, candidate=new)
    for way in pool.get(old.effect.name, ()):
        if way.columns.where == old.columns.where and way.columns.shape == old.columns.shape:
            if way.effect.is_scatter:
                way = replace(way, term=replace(way.term, plausible=old.term.plausible))
            return replace(adopted, candidate=way)
    return adopted
