"""The search among sets of hypotheses: models are grown, thinned and exchanged, and all that weigh are kept.

From several models of one size all of the next are grown, so that no name depends on what was adopted first.
Around the best model each member, and each pair, is taken out and everything is tried in its place. What is within
Occam's window (Raftery, Madigan and Hoeting 1997) of the best stays.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from procedures.inference import priors
from procedures.inference.board import Board
from procedures.inference.marginal import Held, Member, Ranked, ranked

Names = tuple[int, ...]  # numbers of hypotheses, sorted


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Members at their best amplitudes, and ln of the posterior odds against the model without any."""

    members: tuple[Member, ...]
    log_odds: float
    names: Names


@dataclass(eq=False)
class Search:
    """All models that were looked at on one board."""

    board: Board
    models: dict[Names, Model] = field(default_factory=dict)
    _ranked: dict[tuple[Member, ...], Ranked] = field(default_factory=dict)
    _alone: dict[tuple[tuple[Member, ...], int], Ranked] = field(default_factory=dict)

    def ranked_with(self, members: Sequence[Member]) -> Ranked:
        """Return what every hypothesis is worth with members."""
        key = tuple(sorted(members, key=lambda each: each.option))
        if key not in self._ranked:
            self._ranked[key] = ranked(self.board, key)
        return self._ranked[key]

    def alone(self, members: Sequence[Member], hypothesis: int) -> Ranked:
        """Return what one hypothesis is worth with members; nothing of all others."""
        key = tuple(sorted(members, key=lambda each: each.option))
        if key in self._ranked:
            return self._ranked[key]
        if (key, hypothesis) not in self._alone:
            self._alone[key, hypothesis] = ranked(self.board, key, hypothesis)
        return self._alone[key, hypothesis]

    def run(self, begin: Sequence[Member] = ()) -> Model:
        """Return the best model; `models` holds all others."""
        self._keep(Model((), 0.0, ()))
        if begin:
            self._keep(self.polished(begin))
        parents = [self.models[()]]
        for _ in range(priors.LARGEST):
            before, parents = self.best, self._grown(parents)
            if self.best is before:
                break
        around = set[Names]()
        while self.best.names not in around:
            around.add(self.best.names)
            self._around(self.best)
        return self.best

    def widen(self) -> None:
        """Look at everything that may act unseen with each of the likeliest models, not of the best alone."""
        for model in self.window[: priors.BREADTH**2]:
            for child in self._children(model):
                self._keep(child)

    @property
    def best(self) -> Model:
        """The likeliest model."""
        return max(self.models.values(), key=lambda each: each.log_odds)

    @property
    def best_without_unrecorded(self) -> Model:
        """The likeliest model, or one not much less likely in which no temperature that was not recorded acts.

        A temperature that was not recorded may be a drift: what it takes is then no residual.
        """
        least = self.best.log_odds + np.log(1 - priors.LIKELY)
        likely = [m for m in self.window if m.log_odds >= least]
        return next((m for m in likely if not any(map(self._is_unrecorded, m.members))), self.best)

    def _is_unrecorded(self, member: Member) -> bool:
        return self.board.hypotheses[_of(self.board, member)].kind == "unrecorded"

    @property
    def window(self) -> list[Model]:
        """The models within Occam's window, the likeliest first."""
        least = self.best.log_odds - priors.WINDOW
        return sorted((m for m in self.models.values() if m.log_odds >= least), key=lambda m: -m.log_odds)

    def elsewhere(self) -> list[Model]:
        """Return the best model with each of its members at every other place that is as likely."""
        found, best = list[Model](), self.best
        for i, member in enumerate(best.members):
            rest, option = best.members[:i] + best.members[i + 1 :], self.board.options[member.option]
            ranking = self.ranked_with(rest)
            for number in self.board.options_of[option.hypothesis].tolist():
                less = float(ranking.best[number] - ranking.best[member.option])
                if less > -priors.WINDOW and self.board.options[number].place != option.place:
                    moved = Member(number, float(ranking.amplitude[number]))
                    found.append(Model((*rest, moved), best.log_odds + less, best.names))
        return found

    def _keep(self, model: Model) -> None:
        known = self.models.get(model.names)
        if known is None or known.log_odds < model.log_odds:
            self.models[model.names] = model

    def _grown(self, parents: Iterable[Model]) -> list[Model]:
        """Return the likeliest models of one member more than ``parents`` that are likelier than these."""
        found = dict[Names, Model]()
        for parent in parents:
            for child in self._children(parent):
                self._keep(child)
                known = found.get(child.names)
                if child.log_odds > max(parent.log_odds, -np.inf if known is None else known.log_odds):
                    found[child.names] = child
        likeliest = sorted(found.values(), key=lambda each: -each.log_odds)[: priors.BREADTH]
        polished = [self.polished(each.members) for each in likeliest]
        for each in polished:
            self._keep(each)
        return polished

    def _children(self, parent: Model) -> Iterable[Model]:
        """Yield a model with each hypothesis more, while it is no larger than may be."""
        if len(parent.members) >= priors.LARGEST:
            return
        ranking = self.ranked_with(parent.members)
        for i, total in enumerate(ranking.total.tolist()):
            again = self._again(i) if i in parent.names else 0.0
            if np.isfinite(total + again):
                member = ranking.member(self.board, i)
                names = tuple(sorted((*parent.names, i)))
                yield Model((*parent.members, member), parent.log_odds + total + again, names)

    def _again(self, hypothesis: int) -> float:
        """Return by how much likelier it is that a hypothesis acts once more than that it acts."""
        one = self.board.hypotheses[hypothesis]
        return -np.inf if one.log_again is None else one.log_again - one.log_odds

    def polished(self, members: Sequence[Member]) -> Model:
        """Return a model with every member's option and amplitude the best with the others."""
        now, of = list(members), [self.board.options[each.option].hypothesis for each in members]
        for _ in range(priors.LARGEST):  # each change is likelier than what was, but for rounding
            before = list(now)
            for i, hypothesis in enumerate(of):
                now[i] = self.alone(now[:i] + now[i + 1 :], hypothesis).member(self.board, hypothesis)
            if before == now:
                break
        log_odds = Held.of(self.board, now).gain
        for i, hypothesis in enumerate(of):
            ranking = self.alone(now[:i] + now[i + 1 :], hypothesis)
            at = ranking.best[now[i].option]
            volume = ranking.total[hypothesis] - at + self.board.options[now[i].option].log_share
            log_odds += float(volume) + (self._again(hypothesis) if hypothesis in of[:i] else 0.0)
        return Model(tuple(now), log_odds, tuple(sorted(of)))

    def _around(self, model: Model) -> None:
        """Take each member that something else may be, and each pair of few, out and try everything."""
        n = len(model.members)
        open_to = [i for i in range(n) if self._has_rivals(model, i)]
        pairs = [(i, j) for i in range(n) for j in range(i)] if n <= priors.BREADTH else []
        out = [(), *((i,) for i in open_to), *pairs]
        for gone in out:
            rest = tuple(each for k, each in enumerate(model.members) if k not in gone)
            smaller = self.polished(rest)
            self._keep(smaller)
            least = self.best.log_odds - priors.WINDOW
            for child in self._children(smaller):
                if child.log_odds > least:
                    self._keep(child)
            if len(gone) == 1 and self.board.hypotheses[_of(self.board, model.members[gone[0]])].takes_any_shape:
                self._two_for_one(smaller, least)
            # of options that overlap, those that were the best with what is gone may be so again
            as_it_stood = Model(rest, smaller.log_odds, smaller.names)
            for base in [smaller] if set(rest) == set(smaller.members) else [smaller, as_it_stood]:
                for child in sorted(self._children(base), key=lambda each: -each.log_odds)[: priors.BREADTH]:
                    if child.log_odds > least:
                        self._keep(self.polished(child.members))

    def _has_rivals(self, model: Model, i: int) -> bool:
        """Say whether something else, or two causes for one that takes any shape, may be in a member's place."""
        own = _of(self.board, model.members[i])
        if self.board.hypotheses[own].takes_any_shape:
            return True
        total = self.ranked_with(model.members[:i] + model.members[i + 1 :]).total
        return bool(np.any(np.delete(total, own) > total[own] - 2 * priors.WINDOW))

    def _two_for_one(self, smaller: Model, least: float) -> None:
        """Keep what two causes with names do in the place of one that takes any shape."""
        named = (child for child in self._children(smaller) if _is_last_of_one_shape(self.board, child))
        for child in sorted(named, key=lambda each: -each.log_odds)[: priors.BREADTH]:
            for pair in sorted(self._children(child), key=lambda each: -each.log_odds)[: priors.BREADTH]:
                if pair.log_odds > least:
                    self._keep(self.polished(pair.members))


def _of(board: Board, member: Member) -> int:
    return board.options[member.option].hypothesis


def _is_last_of_one_shape(board: Board, model: Model) -> bool:
    return not board.hypotheses[_of(board, model.members[-1])].takes_any_shape
