"""From a base model to causes: rows, hypotheses, search, and the model linearised again where it stands."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, report
from procedures.calibration.reduced_steps import ReducedSteps
from procedures.calibration.solution_values import Solution
from procedures.effects.effect import Effect
from procedures.errors import DoesNotFit
from procedures.evidence.candidates import Candidate, Candidates
from procedures.evidence.linear_model import Term
from procedures.evidence.refit import Refit, refit, terms_at
from procedures.inference import priors
from procedures.inference.board import Board
from procedures.inference.hypotheses import Library, library_of, of_repeats
from procedures.inference.marginal import Member, log_sum, tail
from procedures.inference.nonlinear_constants import resolved
from procedures.inference.posterior import Posterior, averaged_fits, averaged_parameters, posterior
from procedures.inference.result import TableSensor
from procedures.inference.search import Model, Search


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


@dataclass(frozen=True, slots=True, eq=False)
class Inferred:
    """What was inferred: the posterior, the board it is of, the base model and the refit with the best effects in.

    ``refit`` has fits averaged over the models, ``first`` is the base model without any effect, ``pool`` holds the
    ways in which effects may act. ``moved`` is what the average over the models does to the parameters of the last
    linearisation (p,), with the covariance (p, p) that it adds.
    """

    posterior: Posterior
    board: Board
    first: Refit
    refit: Refit
    subject: BaseModel
    pool: Candidates
    moved: tuple[FloatArray, FloatArray]

    @property
    def not_separable(self) -> tuple[str, ...]:
        """The names that this bench cannot tell from its own parameters."""
        return self.board.not_separable


def infer(subject: BaseModel, effects: Sequence[Effect]) -> Inferred:
    """Search, linearise where the best model stands, and search again until its names stay."""
    now = first = subject.refit(())
    pool = Candidates(now.evidence, now.fits, effects)
    library = library_of(now.evidence, pool)
    library = library.with_adopted(now.evidence, list(resolved(library.on(now.evidence))))
    search = begin = Search(library.on(now.evidence))
    best, tried = search.run(), set[tuple[str, ...]]()
    while (names := _names(search.board, best)) not in tried and (wanted := _candidates(search.board, best)):
        tried.add(names)
        try:
            now = subject.refit(wanted)
        except DoesNotFit:
            break
        search = Search(library.with_adopted(now.evidence, _bent(now, pool)).on(now.evidence))
        best = search.run()
    is_noisy = any(search.board.hypotheses[i].kind == "noise" for i in best.names)
    if is_noisy and (repeats := list(of_repeats(now.evidence))):
        library = library.with_noise(repeats)
        search = Search(library.with_adopted(now.evidence, _bent(now, pool)).on(now.evidence))
        search.run()
    found = posterior(search)
    for curved in [each for each in now.added if each.effect.added is not None]:
        search, now, found = _with_alternatives(subject, pool, library, begin, (search, now, found), curved)
    best = search.best_without_unrecorded
    moved = averaged_parameters(search, found)
    fits = now.fits if now.bare is None else averaged_fits(now.bare, moved, search.board.evidence.columns_of)
    wanted = _candidates(search.board, best)
    if {each.effect.name for each in now.added} != {each.effect.name for each in wanted}:
        with suppress(DoesNotFit):  # two linearisations that lead to each other: the model of the last one
            now = subject.refit(wanted)
    return Inferred(found, search.board, first, replace(now, fits=fits), subject, pool, moved)


def _with_alternatives(
    subject: BaseModel,
    pool: Candidates,
    library: Library,
    begin: Search,
    held: tuple[Search, Refit, Posterior],
    curved: Candidate,
) -> tuple[Search, Refit, Posterior]:
    """Hold an effect that is not linear in its coefficients against what else the cause may be.

    Where the model stands with it in, the data are those that it leaves: others are judged fairly only where the
    model stands with them in its place. The likelier one's model is returned, with the shares of both.
    """
    search, now, found = held
    cause = next((each for each in posterior(begin).causes if curved.effect.name in each.shares), None)
    alternatives = (
        [name for name in cause.shares if name in library.names and name != curved.effect.name] if cause else []
    )
    stands = {curved.effect.name: held}
    for name in alternatives:
        number = library.names.index(name)
        member = begin.ranked_with(()).member(begin.board, number)
        alternative = _candidate(begin.board, member)
        if alternative is None:
            continue
        with suppress(DoesNotFit):
            refit = subject.refit([*(each for each in now.added if each is not curved), alternative])
            other = Search(library.with_adopted(refit.evidence, _bent(refit, pool)).on(refit.evidence))
            other.run()
            stands[name] = (other, refit, posterior(other))
    densities = np.array([_log_density(each) for each, _, _ in stands.values()])
    shares = dict(zip(stands, np.exp(densities - log_sum(densities)).tolist(), strict=True))
    likeliest = max(shares, key=lambda name: shares[name])
    search, now, found = stands[likeliest]
    causes = tuple(
        replace(each, probability=each.probability * shares[likeliest], shares=_notable(each.shares | shares))
        if each.hypothesis.name == likeliest
        else each
        for each in found.causes
    )
    return search, now, replace(found, causes=causes)


def _notable(shares: dict[str, float]) -> dict[str, float]:
    return {name: share for name, share in shares.items() if share >= priors.NEGLIGIBLE}


def _log_density(search: Search) -> float:
    """Return ln of the marginal density of the data of a search's best model, but for what all have in common."""
    y = search.board.y
    return search.best.log_odds + float(tail(search.board, np.array(y @ y)))


def _bent(now: Refit, pool: Candidates) -> list[Candidate]:
    """Return the effects in a refit, with their columns at the coefficients found where these are not linear.

    How large they may be is as before, for a unit of its grade: not what they were held by.
    """
    terms, _ = terms_at(now.evidence, now.added, now.values)
    found = list[Candidate]()
    for each, term in zip(now.added, terms, strict=True):
        k = len(each.columns.coefficients) - len(each.columns.nonlinear)
        alike = [
            way
            for way in pool[each.effect.name]
            if (way.columns.shape, way.columns.orders) == (each.columns.shape, each.columns.orders)
        ]
        own = alike[0].term.plausible
        found.append(replace(each, term=Term(term.H[:, :k], own[:k])))
    return found


def _candidates(board: Board, best: Model) -> list[Candidate]:
    """Return the named effects of a model, their coefficients held by the amplitudes at which they stand.

    Bench parameters are in the base model: that one is beyond its prior is in the average over the models alone.
    """
    return [found for each in best.members if (found := _candidate(board, each)) is not None]


def _candidate(board: Board, member: Member) -> Candidate | None:
    option = board.options[member.option]
    way = option.candidate
    if way is None or option.mask is None or option.scale is None or way.effect.is_bench_parameter:
        return None
    k = len(way.columns.coefficients) - len(way.columns.nonlinear)
    plausible = way.effect.plausible_of(way.columns)[:k] * np.sqrt(
        np.finfo(float).eps
    )  # as good as zero: it does not act
    plausible[option.mask] = option.scale * member.amplitude
    return replace(way, term=Term(way.term.H[:, :k], plausible))


def _names(board: Board, model: Model) -> tuple[str, ...]:
    return tuple(sorted(board.hypotheses[i].name for i in model.names))
