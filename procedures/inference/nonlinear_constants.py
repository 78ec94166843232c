"""Time constants, plays and knees: finer between the points of a grid, and resolved where the data want them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.effects.term.law import alike
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import Term
from procedures.inference import priors
from procedures.inference.board import Board
from procedures.inference.marginal import ranked

WIDEST = 0.5  # of a logarithm, where a grid has one point
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
    """Yield what alone is likelier than nothing and not linear, with its constants where the data are fitted best.

    The nearest point of a grid leaves many sigmas of a large effect, as of a knee at which a range ends: other
    causes would make up for that.
    """
    alone = ranked(board, ())
    for i in np.flatnonzero(alone.total > 0).tolist():
        option = board.options[alone.member(board, i).option]
        if option.candidate is not None and option.is_bent and option.mask is not None:
            found, mask = option.candidate, option.mask.tolist()
            every = [board.options[j].candidate for j in board.options_of[i].tolist()]
            ways = [each.columns for each in every if each is not None]
            for name, value in found.columns.nonlinear.items():
                grid = np.log([way.nonlinear[name] for way in ways if way.shape == found.columns.shape])
                apart = np.abs(grid - np.log(value))
                found = _resolved(board, found, name, mask, float(np.min(apart[apart > 0], initial=WIDEST)))
            yield found


def _resolved(board: Board, one: Candidate, name: str, mask: list[int], apart: float) -> Candidate:
    """Return a candidate with one constant where its coefficients in ``mask`` leave least of the data.

    It is looked for as far as the next point of the grid, ``apart`` in the logarithm.
    """
    low, high = one.effect.ranges.get(name, (0.0, np.inf))

    def at(log: float) -> Candidate:
        value = float(np.clip(np.exp(log), low, high))
        assert one.effect.at is not None
        columns = one.effect.at(
            board.evidence.excitation, replace(one.columns, nonlinear={**one.columns.nonlinear, name: value})
        )
        H = board.evidence.column(columns)[:, : one.term.H.shape[1]]
        return replace(one, columns=columns, term=Term(H, one.term.plausible))

    def left(log: float) -> float:
        W = board.basis.T @ (at(log).term.H[:, mask] / board.evidence.sigma[:, None])
        c, *_ = np.linalg.lstsq(W, board.y, rcond=None)
        return float(np.sum((board.y - W @ c) ** 2))

    middle = float(np.log(one.columns.nonlinear[name]))
    ends = middle - apart, middle + apart
    return at(float(minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": 1e-4}).x))
