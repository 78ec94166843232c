"""The order of placements that is best by a score: exchange of one placement at a time, from many beginnings.

What the placements before and after one say is kept, so that all attitudes in its place are tried at once
(Fedorov's exchange, 1972, on a chain). Every beginning is a walk at random, a flip from attitude to attitude. No
attitude comes twice: what is repeated in a plan is done at its end (`procedures.campaign.plan_steps.as_repeats`).
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.planning.campaign_design import CampaignDesign, Placement
from procedures.planning.design_sigmas import DesignSigmas, WantedSigmas, joined, without_first
from procedures.planning.placement_rows import OWN
from procedures.positions import ATTITUDES, nominal_C_lb

PLACEMENTS_OF_STARTS = 150  # in all walks together: short orders have more beginnings
MAX_SWEEPS = 20
MAX_WALKS = 50  # at random, for one that gets as far as asked
LEAST_GAIN = 1e-6  # of the score
THIRD_OF_A_TURN = 0.0  # trace of its rotation, between those of a quarter (1) and of half a turn (-1)
ALL = range(1, len(ATTITUDES) + 1)


def flips() -> BoolArray:
    """Say (24, 24), without unit, which attitude follows which by a quarter or half a turn about one axis."""
    C = np.array([nominal_C_lb(position) for position in ALL])
    trace = np.einsum("aij,bij->ab", C, C).round()
    is_flip: BoolArray = (trace != THIRD_OF_A_TURN) & ~np.eye(len(C), dtype=bool)
    return is_flip


class OrderSearch:
    """Searches orders of dwells of ``seconds`` each, positions ``among``, with the turns ``tail`` after them.

    ``head`` are placements that were done before: they stay, and none of them comes again.
    """

    def __init__(
        self, sigmas: DesignSigmas, wanted: WantedSigmas, seconds: float, among: Sequence[int] = ALL,
        tail: Sequence[Placement] = (), head: Sequence[Placement] = (),
    ) -> None:  # fmt: skip
        self._sigmas, self._wanted, self._tail, self._head = sigmas, wanted, tuple(tail), tuple(head)
        self._positions = np.setdiff1d(among, [at.position for at in head]).astype(np.int64)
        self._dwells = [Placement(position, seconds) for position in self._positions.tolist()]
        self._can_follow = flips()[np.ix_(self._positions - 1, self._positions - 1)]

    def can_go_on(self) -> bool:
        """Say whether there is a dwell that can be the first."""
        return bool(np.any(self._can_begin))

    def best(self, n: int, seed: int = 0, beginnings: int | None = None) -> tuple[CampaignDesign, float]:
        """Return the best order of ``n`` dwells that was found, and its score; fewer where no walk has so many."""
        rng = np.random.default_rng(seed)
        found = [self._exchanged(self._walk(n, rng)) for _ in range(beginnings or PLACEMENTS_OF_STARTS // n)]
        score, order = min(found, key=lambda each: each[0])
        return self._design(order), score

    def improved(self, design: CampaignDesign) -> tuple[CampaignDesign, float]:
        """Return what exchanges make of an order, and its score."""
        positions = [at.position for at in self._dwells]
        score, order = self._exchanged([positions.index(p) for p in design.positions])
        return self._design(order), score

    def _design(self, order: Sequence[int]) -> CampaignDesign:
        return CampaignDesign((*self._head, *(self._dwells[i] for i in order), *self._tail))

    def _walk(self, n: int, rng: np.random.Generator) -> list[int]:
        longest = list[int]()
        for _ in range(MAX_WALKS):
            order = list[int]()
            while len(order) < n:
                next_ones = self._can_follow[order[-1]] if order else self._can_begin
                left = np.setdiff1d(np.flatnonzero(next_ones), order)
                if not len(left):
                    break
                order.append(int(rng.choice(left)))
            if len(order) == n:
                return order
            longest = max(longest, order, key=len)
        return longest

    def _exchanged(self, order: list[int]) -> tuple[float, list[int]]:
        """Exchange one placement after the other for the best in its place, until nothing is gained."""
        score = float(self._wanted.score(self._sigmas.of(self._design(order))))
        for _ in range(MAX_SWEEPS):
            before, after = score, self._ends(order)
            chain = self._begun
            for i, now in enumerate(order):
                fitting = np.flatnonzero(self._fits(order, i))
                scores = self._scores(order, i, fitting, chain, after[i])
                best = int(np.argmin(scores))
                if fitting[best] != now and scores[best] < score * (1 - LEAST_GAIN):
                    order[i], score = int(fitting[best]), float(scores[best])
                chain = self._with(chain, order, i)
            if score >= before * (1 - LEAST_GAIN):
                break
        return score, order

    def _fits(self, order: Sequence[int], i: int) -> BoolArray:
        fits = np.ones(len(self._dwells), dtype=bool)
        fits[[j for at, j in enumerate(order) if at != i]] = False
        np.logical_and(fits, self._can_follow[order[i - 1]] if i else self._can_begin, out=fits)
        if i + 1 < len(order):
            fits &= self._can_follow[:, order[i + 1]]
        return fits

    def _scores(
        self, order: Sequence[int], i: int, among: IntArray, chain: FloatArray | None, after: FloatArray
    ) -> FloatArray:
        """Return the scores (f,) of dwells ``among`` (f,) in the place i: after a chain, before (c, 43, 43)."""
        N = self._placed[among] + after[among]
        if chain is None:
            N[:, OWN:, OWN:] += self._sigmas.known
        else:
            before = self._dwells[order[i - 1]] if i else self._head[-1]
            N += joined(chain, self._sigmas.steps.moved(before.position, self._positions[among]))
        others = [j for at, j in enumerate(order) if at != i]
        information = self._information[others].sum(axis=0) + self._information[among]
        dwells = len(order) + sum(at.turn is None for at in self._head)
        sigmas = self._sigmas.by_information(information + self._decided_before, without_first(N), dwells)
        return self._wanted.score(sigmas)

    def _with(self, chain: FloatArray | None, order: Sequence[int], i: int) -> FloatArray:
        """Return the chain with the dwell in the place i."""
        at = self._dwells[order[i]]
        if chain is None:
            return self._sigmas.begun(at)
        return self._sigmas.carried_on(chain, self._dwells[order[i - 1]] if i else self._head[-1], at)

    def _ends(self, order: Sequence[int]) -> list[FloatArray]:
        """Return for every place what the dwells and turns after it say of each dwell in it (c, 43, 43).

        Of a dwell that the next one cannot follow they say nothing: it is not tried there.
        """
        found, steps = [self._by_tail], self._sigmas.steps
        for i in range(len(order) - 1, 0, -1):
            at = self._dwells[order[i]]
            chain = steps.placed(at) + found[-1][order[i]]
            before = self._can_follow[:, order[i]]
            found.append(np.zeros(self._placed.shape))
            found[-1][before] = joined(chain, steps.moved_back(self._positions[before], at.position))
        return found[::-1]

    @cached_property
    def _begun(self) -> FloatArray | None:
        """The chain (43, 43) of what was done before, None where nothing was."""
        return self._sigmas.chain(CampaignDesign(self._head)) if self._head else None

    @cached_property
    def _can_begin(self) -> BoolArray:
        """Which dwells (c,) may come first."""
        after = [at.position - 1 for at in self._head[-1:]]
        return np.asarray(flips()[after][:, [at.position - 1 for at in self._dwells]].all(axis=0))

    @cached_property
    def _decided_before(self) -> FloatArray:
        information = [self._sigmas.steps.information(at) for at in self._head if at.turn is None]
        return np.sum(information, axis=0) if information else np.zeros_like(self._information[0])

    @cached_property
    def _by_tail(self) -> FloatArray:
        """What the turns after the last dwell say of each dwell (c, 43, 43)."""
        if not self._tail:
            return np.zeros_like(self._placed)
        steps = self._sigmas.steps
        chain = steps.placed(self._tail[-1])
        for before, after in zip(self._tail[-2::-1], self._tail[:0:-1], strict=True):
            chain = steps.placed(before) + joined(chain, steps.moved_back(before.position, after.position))
        return joined(chain, steps.moved_back(self._positions, self._tail[0].position))

    @cached_property
    def _placed(self) -> FloatArray:
        return np.array([self._sigmas.steps.placed(at) for at in self._dwells])

    @cached_property
    def _information(self) -> FloatArray:
        return np.array([self._sigmas.steps.information(at) for at in self._dwells])
