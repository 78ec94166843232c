"""Time constants, plays and knees: finer between the points of a grid, and resolved where the data want them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.arrays import FloatArray
from procedures.effects.term.law import alike
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import Term
from procedures.inference import priors
from procedures.inference.board import Board, Hypothesis
from procedures.inference.marginal import Member, ranked, stacked

WIDEST = 0.5  # of a logarithm, where a grid has one point
STEP = 1e-4  # of a logarithm, to which a constant is resolved
CUBIC = 4  # neighbours that a cubic goes through


def between(candidates: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield more candidates between neighbours on a grid of a time constant.

    A column is smooth in the constant's logarithm: it is interpolated by a cubic through four neighbours, where
    these are alike. Of periods they are not, and one that acts is resolved.
    """
    lines = dict[tuple[object, ...], list[Candidate]]()
    for each in candidates:
        if len(each.columns.nonlinear) == 1:
            key = (each.columns.shape, each.columns.orders, str(each.columns.where))
            lines.setdefault(key, []).append(each)
    for line in lines.values():
        if len(line) < CUBIC:
            continue
        line.sort(key=lambda each: next(iter(each.columns.nonlinear.values())))
        (name,) = line[0].columns.nonlinear
        x = np.log([each.columns.nonlinear[name] for each in line])
        is_fine = [_alike(a.term, b.term) for a, b in pairwise(line)]
        for i in range(len(line) - 1):
            first = min(max(i - 1, 0), len(line) - CUBIC)
            near = range(first, first + CUBIC)
            if not all(is_fine[first : first + CUBIC - 1]):
                continue
            for part in range(1, priors.FINER):
                at = x[i] + (x[i + 1] - x[i]) * part / priors.FINER
                weights = [np.prod([(at - x[k]) / (x[j] - x[k]) for k in near if k != j]) for j in near]
                H = np.tensordot(weights, np.stack([line[j].term.H for j in near]), 1)
                columns = replace(line[i].columns, nonlinear={name: float(np.exp(at))})
                yield replace(line[i], columns=columns, term=Term(H, line[i].term.plausible))


def _alike(one: Term, other: Term) -> bool:
    return all(alike(a, b) for a, b in zip(one.H.T, other.H.T, strict=True))


def resolved(board: Board) -> Iterator[Candidate]:
    """Yield what is likelier than nothing and not linear, with its constants where the data are fitted best.

    The nearest point of a grid leaves many sigmas of a large effect, as of a knee at which a range ends: other
    causes would make up for that. Each stands alone, and next to the plain effect that goes by the same: a play
    next to a temperature coefficient is another one than alone.
    """
    alone = ranked(board, ())
    for i, hypothesis in enumerate(board.hypotheses):
        if not any(board.options[j].is_bent for j in board.options_of[i].tolist()):
            continue
        for plain in (None, *_plain_of(board, hypothesis)):
            members = () if plain is None else (alone.member(board, plain),)
            now = alone if plain is None else ranked(board, members, i)
            option = board.options[now.member(board, i).option]
            if now.total[i] > 0 and option.candidate is not None and option.is_bent and option.mask is not None:
                found, mask = option.candidate, option.mask.tolist()
                every = [board.options[j].candidate for j in board.options_of[i].tolist()]
                ways = [each.columns for each in every if each is not None]
                for name, value in found.columns.nonlinear.items():
                    grid = np.log([way.nonlinear[name] for way in ways if way.shape == found.columns.shape])
                    apart = np.abs(grid - np.log(value))
                    near = float(np.min(apart[apart > 0], initial=WIDEST))
                    found = _resolved(board, found, name, mask, near, members)
                yield found


def _plain_of(board: Board, bent: Hypothesis) -> Iterator[int]:
    """Yield the hypotheses of the same triad and driver that are linear and act throughout."""
    for i, each in enumerate(board.hypotheses):
        if each.effect is None or bent.effect is None or each is bent:
            continue
        is_same = each.effect.driver == bent.effect.driver and each.name.split(".")[0] == bent.name.split(".")[0]
        ways = [board.options[j] for j in board.options_of[i].tolist()]
        if is_same and ways and all(each.is_plain for each in ways):
            yield i


def _resolved(
    board: Board, one: Candidate, name: str, mask: list[int], apart: float, members: Sequence[Member]
) -> Candidate:
    """Return a candidate with one constant where it and ``members`` leave least of the data.

    It is looked for as far as the next point of the grid, ``apart`` in the logarithm. A point of the grid stands
    for so much of the prior; this one for what the data leave of it, 1 sigma times sqrt(2 pi) (Laplace).
    """
    low, high = one.effect.ranges.get(name, (0.0, np.inf))
    others = stacked(board, members)

    def at(log: float) -> Candidate:
        value = float(np.clip(np.exp(log), low, high))
        assert one.effect.at is not None
        columns = one.effect.at(
            board.evidence.excitation, replace(one.columns, nonlinear={**one.columns.nonlinear, name: value})
        )
        H = board.evidence.column(columns)[:, : one.term.H.shape[1]]
        return replace(one, columns=columns, term=Term(H, one.term.plausible))

    def columns_at(log: float) -> FloatArray:
        own = board.basis.T @ (at(log).term.H[:, mask] / board.evidence.sigma[:, None])
        return np.hstack((others, own))

    def left(log: float) -> float:
        W = columns_at(log)
        c, *_ = np.linalg.lstsq(W, board.y, rcond=None)
        return float(np.sum((board.y - W @ c) ** 2))

    middle = float(np.log(one.columns.nonlinear[name]))
    ends = middle - apart, middle + apart
    best = float(minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": STEP}).x)
    W = columns_at(best)
    c, *_ = np.linalg.lstsq(W, board.y, rcond=None)
    slope = (columns_at(best + STEP) - columns_at(best - STEP)) @ c / (2 * STEP)
    slope = slope - W @ np.linalg.lstsq(W, slope, rcond=None)[0]
    width = np.sqrt(2 * np.pi) / max(float(np.linalg.norm(slope)), 1e-300)
    return replace(at(best), log_volume=one.log_volume + min(float(np.log(width / apart)), 0.0))
