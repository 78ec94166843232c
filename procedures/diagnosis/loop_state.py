"""Where the loop stands: what was adopted, the model solved with it, and every candidate seen from there."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from procedures.diagnosis.base_model import Subject
from procedures.diagnosis.candidates import Candidate, candidates
from procedures.diagnosis.effect_selection import Adopted
from procedures.diagnosis.linear_model import Term
from procedures.diagnosis.refit import Refit, terms_at
from procedures.effects.effect import Effect

Pool = Mapping[str, Sequence[Candidate]]


@dataclass(frozen=True, eq=False)
class State:
    """Where the loop stands."""

    subject: Subject
    adopted: tuple[Adopted, ...]
    now: Refit
    pool: Pool

    def beside(self, but: Candidate | None = None) -> list[Term]:
        """Return the terms added to the model, but for one."""
        return [each.term for each in self.adopted if not each.candidate.is_of_model and each.candidate is not but]


def stand(subject: Subject, adopted: Sequence[Adopted], effects: Sequence[Effect]) -> State:
    """Solve with what was adopted and look again at everything from there."""
    now = subject.refit([each.candidate for each in adopted])
    pool = candidates(now.evidence, now.fits, effects)
    found = [_found_again(each, pool) for each in adopted]
    return State(subject, tuple(_bent(found, now)), now, pool)


def _bent(adopted: Sequence[Adopted], now: Refit) -> Iterator[Adopted]:
    """Yield effects that are not linear with their columns at the coefficients found."""
    values = iter(now.values)
    for each in adopted:
        candidate = each.candidate
        value = None if candidate.is_of_model else next(values)
        if value is not None and candidate.effect.added is not None:
            (term,), _ = terms_at(now.evidence, [candidate], [value])
            each = replace(each, candidate=replace(candidate, term=term))
        yield each


def _found_again(adopted: Adopted, pool: Pool) -> Adopted:
    """Return an adopted effect with its columns where the model now stands."""
    old = adopted.candidate
    for way in pool.get(old.effect.name, ()):
        if way.columns.where == old.columns.where and way.columns.shape == old.columns.shape:
            return replace(adopted, candidate=way)
    return adopted
