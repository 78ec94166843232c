"""Hypotheses on an evidence: columns in the complement of the model's own, and the prior of each."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.effects.effect import Effect
from procedures.evidence.candidates import Candidate
from procedures.evidence.residual_rows import Evidence
from procedures.inference import priors
from procedures.statistics.least_squares import left_singular


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A name, ln of its prior odds, the amplitudes (m,) it may have, and what it is.

    ``kind`` is that of its effect, ``nameless`` for a function that no catalogue holds, ``noise`` for a class of
    rows. ``log_again`` is ln of the odds that it acts once more, in another place or by another coefficient; None
    where it acts once. ``driver`` is what drives a curve of free shape, "" of all else.
    """

    name: str
    kind: str
    log_odds: float
    amplitudes: FloatArray
    effect: Effect | None = None
    log_again: float | None = None
    driver: str = ""

    @property
    def log_weights(self) -> FloatArray:
        """Ln of the weights (m,) [1] of its amplitudes: a coefficient beyond what is stated is rarer."""
        is_named = self.amplitudes is priors.OF_NAMED
        return priors.log_weights(self.amplitudes) if is_named else np.zeros(len(self.amplitudes))

    @property
    def curve(self) -> str:
        """What it is where its own law does not hold: a function of what drives it."""
        return f"a function of {self.driver}" if self.is_named and self.driver else self.name

    @property
    def is_named(self) -> bool:
        """Say whether an effect of the catalogue stands behind it."""
        return self.effect is not None

    @property
    def takes_any_shape(self) -> bool:
        """Say whether it may stand for several causes: a function without a name, or draws."""
        return self.effect is None or self.effect.is_scatter


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """One way in which a hypothesis may hold: ln of its share, its columns of `Board.W`, what it is made of.

    ``scale`` (k,) is 1 sigma of the coefficients at amplitude 1, in the effect's unit; ``mask`` which of the
    candidate's coefficients they are. ``taken`` (k, p) are the rows of an orthonormal basis of the model's columns
    where each column of the option is one row alone, as of wider noise: then ``W'W = I - taken taken'``.
    """

    hypothesis: int
    log_share: float
    columns: IntArray
    candidate: Candidate | None = None
    mask: IntArray | None = None
    scale: FloatArray | None = None
    note: str = ""
    taken: FloatArray | None = None

    @property
    def place(self) -> str:
        """Where it acts, as text."""
        return "" if self.candidate is None else str(self.candidate.columns.where)

    @property
    def coefficients(self) -> frozenset[str]:
        """The names of the coefficients that act; the line's x is the parabola's x.1."""
        if self.candidate is None or self.mask is None:
            return frozenset()
        names = self.candidate.columns.coefficients
        return frozenset(names[i].removesuffix(".1") for i in self.mask)

    @property
    def is_bent(self) -> bool:
        """Say whether it has a time constant, or what else is not linear."""
        return self.candidate is not None and bool(self.candidate.columns.nonlinear)

    @property
    def is_plain(self) -> bool:
        """Say whether an effect is linear and acts at one place only: throughout."""
        one = self.candidate
        return one is not None and not (one.columns.nonlinear or one.columns.where or one.effect.is_scatter)


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Options of at most k columns, filled with zeros.

    ``options`` (b,) are their numbers, ``columns`` (b, k) those of `Board.W`; G = W'W (b, k, k), g = W'y (b, k).
    """

    options: IntArray
    columns: IntArray
    G: FloatArray
    g: FloatArray
    amplitudes: FloatArray
    log_weights: FloatArray
    is_loss: bool


@dataclass(frozen=True, eq=False)
class Board:
    """The evidence with the model's own parameters integrated out, and every hypothesis next to it.

    ``y`` (m,) is the whitened residual in the complement of the model's columns, ``W`` (m, N) all columns there,
    the last of which is zero, ``H`` (n, N) the same on all rows. ``basis`` (n, m) spans the complement.
    """

    evidence: Evidence
    H: FloatArray
    y: FloatArray
    W: FloatArray
    hypotheses: tuple[Hypothesis, ...]
    options: tuple[Option, ...]
    basis: FloatArray

    @cached_property
    def not_separable(self) -> tuple[str, ...]:
        """The names that would show if the bench's parameters were known, and do not while these are free.

        A quadratic term next to faces without a certificate is one. What the campaign does not excite is none.
        """
        data = ~self.evidence.is_range
        A = (self.evidence.A / self.evidence.sigma[:, None])[data]
        of_bench = np.any(self.evidence.A[~data] != 0, axis=0)
        known, free = self._shown(data, A[:, ~of_bench]), self._shown(data, A)
        return tuple(each.name for each in self.hypotheses if each.name in known and each.name not in free)

    def _shown(self, data: BoolArray, A: FloatArray) -> set[str]:
        """Return the names of which an option shows by a sigma in data next to parameters of columns A."""
        U, size = left_singular(A)
        Q = U[:, size > np.finfo(float).eps * len(A) * np.max(size, initial=0.0)]
        whole = np.linalg.norm(self.H[data], axis=0)
        seen = np.linalg.norm(self.H[data] - Q @ (Q.T @ self.H[data]), axis=0)
        seen = np.where(seen > priors.NEGLIGIBLE * whole, seen, 0.0)
        most = [(self.hypotheses[each.hypothesis], seen[each.columns]) for each in self.options]
        return {one.name for one, by in most if one.amplitudes[-1] * np.max(by, initial=0.0) > 1.0}

    @cached_property
    def options_of(self) -> Sequence[IntArray]:
        """The numbers (k,) of every hypothesis' options."""
        of = np.array([each.hypothesis for each in self.options])
        return [np.flatnonzero(of == i) for i in range(len(self.hypotheses))]

    @cached_property
    def same_as(self) -> Sequence[IntArray]:
        """The numbers (k,) of the options that hold a coefficient of every option's own at its place, and itself.

        Both at once are one option more than there is: another coefficient acts, or the same one elsewhere.
        """
        at = dict[tuple[object, ...], list[int]]()
        for i, each in enumerate(self.options):
            shape = each.candidate.columns.shape if each.candidate else ""
            at.setdefault((each.hypothesis, each.place, shape), []).append(i)
        found: list[IntArray] = [np.array([i]) for i in range(len(self.options))]
        for together in at.values():
            names = [self.options[i].coefficients for i in together]
            for i, own in zip(together, names, strict=True):
                found[i] = np.array([j for j, other in zip(together, names, strict=True) if j == i or own & other])
        return found

    @cached_property
    def blocks(self) -> Sequence[Block]:
        """All options, those of about as many columns together; but those of single rows."""
        return list(_blocks(self, range(len(self.options))))

    @cached_property
    def blocks_of(self) -> Sequence[Sequence[Block]]:
        """Every hypothesis' own options as `blocks`."""
        return [list(_blocks(self, own.tolist())) for own in self.options_of]


def _blocks(board: Board, options: Iterable[int]) -> Iterator[Block]:
    kinds = dict[tuple[int, bool], list[int]]()
    for i in options:
        option = board.options[i]
        if option.taken is not None:
            continue
        effect = board.hypotheses[option.hypothesis].effect
        k = 1 << max(len(option.columns) - 1, 0).bit_length()
        kinds.setdefault((k, effect is not None and effect.is_loss), []).append(i)
    for (k, is_loss), which in kinds.items():
        columns = np.full((len(which), k), board.W.shape[1] - 1)
        for row, i in zip(columns, which, strict=True):
            row[: len(board.options[i].columns)] = board.options[i].columns
        W = np.moveaxis(board.W[:, columns], 0, 2)  # (b, k, m)
        amplitudes = np.array([board.hypotheses[board.options[i].hypothesis].amplitudes for i in which])
        weights = np.array([board.hypotheses[board.options[i].hypothesis].log_weights for i in which])
        yield Block(np.array(which), columns, W @ np.swapaxes(W, 1, 2), W @ board.y, amplitudes, weights, is_loss)
