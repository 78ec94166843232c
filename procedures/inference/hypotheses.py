"""A hypothesis is columns and a prior: what would show in the rows, and how large it may be.

Named effects, scatters, random walks, wider noise of a class of rows and smooth functions without a name are all
of this one kind. A hypothesis has options, each with its share of the prior: where an effect acted, at which time
constant, in all sensors or in one.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.linear_model import Term, variance_classes
from procedures.diagnosis.residual_rows import KINDS, Evidence
from procedures.effects.effect import Effect
from procedures.frames import AXES, TRIADS
from procedures.inference import priors
from procedures.inference.smooth_functions import functions, walk


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A name, ln of its prior odds, the amplitudes (m,) it may have, and what it is.

    ``kind`` is that of its effect, ``nameless`` for a function that no catalogue holds, ``noise`` for a class of
    rows. ``repeats``: it may act more than once, each time elsewhere.
    """

    name: str
    kind: str
    log_odds: float
    amplitudes: FloatArray
    effect: Effect | None = None
    repeats: bool = False

    @property
    def is_named(self) -> bool:
        """Say whether an effect of the catalogue stands behind it."""
        return self.effect is not None


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """One way in which a hypothesis may hold: ln of its share, its columns of `Board.W`, what it is made of.

    ``scale`` (k,) is 1 sigma of the coefficients at amplitude 1, in the effect's unit; ``mask`` which of the
    candidate's coefficients they are.
    """

    hypothesis: int
    log_share: float
    columns: IntArray
    candidate: Candidate | None = None
    mask: IntArray | None = None
    scale: FloatArray | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class Board:
    """The evidence with the model's own parameters integrated out, and every hypothesis beside it.

    ``y`` (m,) is the whitened residual in the complement of the model's columns, ``W`` (m, N) all columns there,
    the last of which is zero.
    ``basis`` (n, m) takes rows to it.
    """

    evidence: Evidence
    basis: FloatArray
    y: FloatArray
    W: FloatArray
    hypotheses: tuple[Hypothesis, ...]
    options: tuple[Option, ...]

    @cached_property
    def number(self) -> Mapping[str, int]:
        """Number of every hypothesis by its name."""
        return {each.name: i for i, each in enumerate(self.hypotheses)}

    @cached_property
    def separable(self) -> Mapping[str, bool]:
        """Say of every name whether any of its options leaves something beside the model's own parameters."""
        seen = np.linalg.norm(self.W, axis=0)
        found = dict.fromkeys((each.name for each in self.hypotheses), False)
        for option in self.options:
            at = self.hypotheses[option.hypothesis]
            found[at.name] |= bool(at.amplitudes[-1] * np.max(seen[option.columns], initial=0.0) > 1.0)
        return found


class _Collected:
    """Collects hypotheses, their options and columns."""

    def __init__(self, evidence: Evidence) -> None:
        white = evidence.A / evidence.sigma[:, None]
        Q, _ = np.linalg.qr(white, mode="complete")
        self.evidence, self.basis = evidence, Q[:, white.shape[1] :]
        self.y = self.basis.T @ (evidence.residual / evidence.sigma)
        self.parts, self.width = list[FloatArray](), 0
        self.hypotheses, self.options = list[Hypothesis](), list[Option]()

    def add(self, H: FloatArray) -> IntArray:
        """Take in whitened columns H (n, k); return their numbers."""
        return self.take(self.basis.T @ H)

    def take(self, W: FloatArray) -> IntArray:
        self.parts.append(W)
        self.width += W.shape[1]
        return np.arange(self.width - W.shape[1], self.width)

    def board(self) -> Board:
        W = np.hstack([*self.parts, np.zeros((len(self.y), 1))])
        return Board(
            self.evidence, self.basis, self.y, W, tuple(self.hypotheses), tuple(self.options)
        )  # fmt: skip


def board_of(evidence: Evidence, pool: Mapping[str, Sequence[Candidate]], adopted: Sequence[Candidate] = ()) -> Board:
    """Return every hypothesis beside an evidence.

    Parameters
    ----------
    evidence : rows where the model stands
    pool : by name, the ways in which effects may act
    adopted : ways at the time constants that were fitted, which the pool need not hold
    """
    found = _Collected(evidence)
    for name, ways in pool.items():
        tried = [way for way in ways if way.is_tried and not way.is_of_model]
        if tried:
            _named(found, name, tried, [each for each in adopted if each.effect.name == name])
    for name, options in functions(evidence).items():
        _nameless(found, name, options)
    for triad in TRIADS:
        if (options := walk(evidence, triad)):
            _nameless(found, f"random walk of the bias, {triad}", options)
    _noise(found)
    return found.board()


def _named(found: _Collected, name: str, ways: Sequence[Candidate], adopted: Sequence[Candidate]) -> None:
    effect, number = ways[0].effect, len(found.hypotheses)
    bounds = priors.AMPLITUDE_SCATTER if effect.is_scatter else priors.AMPLITUDE_NAMED
    places = any(way.columns.where for way in ways)
    found.hypotheses.append(
        Hypothesis(name, effect.kind, float(np.log(priors.ODDS_NAMED)), priors.grid(bounds), effect, places)
    )
    finer = [(way, W, scale) for way, W, scale in _finer(found, ways)]
    finer += [(way, *_whitened(found, way)) for way in adopted if way.columns.nonlinear]
    for way, W, scale in finer:
        columns = found.take(W)
        for log_share, mask in masks(way):
            found.options.append(
                Option(number, log_share - float(np.log(len(finer))), columns[mask], way, mask, scale[mask])
            )


def _whitened(found: _Collected, way: Candidate) -> tuple[FloatArray, FloatArray]:
    """Return a way's columns beside the model, times 1 sigma of its coefficients, and that (k,)."""
    k = len(way.columns.coefficients) - len(way.columns.nonlinear)
    plausible = way.effect.plausible_of(way.columns) if way.effect.is_scatter else way.term.plausible
    H = way.term.H[:, :k] * plausible[:k]
    return found.basis.T @ (H / found.evidence.sigma[:, None]), plausible[:k]


def _finer(found: _Collected, ways: Sequence[Candidate]) -> Iterator[tuple[Candidate, FloatArray, FloatArray]]:
    """Yield ways with their columns, and between neighbours on a grid of a time constant more of them.

    A column is smooth in the constant's logarithm: it is interpolated by a cubic through four neighbours.
    """
    made = [(way, *_whitened(found, way)) for way in ways]
    yield from made
    lines = dict[tuple[object, ...], list[tuple[Candidate, FloatArray, FloatArray]]]()
    for each in made:
        if len(each[0].columns.nonlinear) == 1:
            columns = each[0].columns
            lines.setdefault((columns.shape, columns.orders, str(columns.where)), []).append(each)
    for line in lines.values():
        line.sort(key=lambda each: next(iter(each[0].columns.nonlinear.values())))
        if len(line) >= 4:
            yield from _between(line)


def _between(
    line: Sequence[tuple[Candidate, FloatArray, FloatArray]],
) -> Iterator[tuple[Candidate, FloatArray, FloatArray]]:
    (name,) = line[0][0].columns.nonlinear
    x = np.log([way.columns.nonlinear[name] for way, _, _ in line])
    for i in range(len(line) - 1):
        first = min(max(i - 1, 0), len(line) - 4)
        near = range(first, first + 4)
        for part in range(1, priors.FINER):
            at = x[i] + (x[i + 1] - x[i]) * part / priors.FINER
            weights = [np.prod([(at - x[k]) / (x[j] - x[k]) for k in near if k != j]) for j in near]
            W = sum((w * line[j][1] for w, j in zip(weights, near, strict=True)), np.zeros_like(line[i][1]))
            H = sum((w * line[j][0].term.H for w, j in zip(weights, near, strict=True)), 0 * line[i][0].term.H)
            way = line[i][0]
            columns = replace(way.columns, nonlinear={name: float(np.exp(at))})
            yield replace(way, columns=columns, term=Term(H, way.term.plausible)), W, line[i][2]


def masks(way: Candidate) -> Iterator[tuple[float, IntArray]]:
    """Yield which coefficients of a way act, with ln of the share: all, those of one sensor, or one alone."""
    names = way.columns.coefficients[: len(way.columns.coefficients) - len(way.columns.nonlinear)]
    every = np.arange(len(names))
    if way.effect.is_scatter or len(names) == 1:
        yield 0.0, every
        return
    sensors = sorted({each[0] for each in names})
    own = [np.array([i for i in every if names[i][0] == each]) for each in sensors]
    levels = [[every]]
    if 1 < len(own) < len(names):
        levels.append(own)
    levels.append([every[i : i + 1] for i in every])
    for level in levels:
        for mask in level:
            yield -float(np.log(len(levels) * len(level))), mask


def _nameless(found: _Collected, name: str, options: Sequence[tuple[float, FloatArray, str]]) -> None:
    number = len(found.hypotheses)
    found.hypotheses.append(
        Hypothesis(name, "nameless", float(np.log(priors.ODDS_NAMELESS)), priors.grid(priors.AMPLITUDE_NAMELESS))
    )
    total = sum(share for share, _, _ in options)
    for share, H, note in options:
        columns = found.take(compressed(found.basis.T @ H))
        found.options.append(Option(number, float(np.log(share / total)), columns, note=note))


def compressed(W: FloatArray) -> FloatArray:
    """Return the fewest columns of the same covariance W W', but for what is `priors.KEPT` of the largest."""
    if not W.shape[1]:
        return W
    variances, V = np.linalg.eigh(W.T @ W)
    found: FloatArray = W @ V[:, variances > priors.KEPT * max(float(variances[-1]), 1e-300)]
    return found


def _noise(found: _Collected) -> None:
    """Take in that a class of rows is noisier than its samples say."""
    shared = variance_classes(found.evidence)
    for number in np.unique(shared[shared > 0]).tolist():
        rows = np.flatnonzero(shared == number)
        triad, kind = divmod(number - 1, len(KINDS))
        if len(rows) > len(AXES):
            name = f"wider noise of {KINDS[kind]} rows, {TRIADS[triad]}"
            columns = found.take(compressed(found.basis[rows].T))
            found.hypotheses.append(
                Hypothesis(name, "noise", float(np.log(priors.ODDS_NOISE)), priors.grid(priors.AMPLITUDE_NOISE))
            )
            found.options.append(Option(len(found.hypotheses) - 1, 0.0, columns))
