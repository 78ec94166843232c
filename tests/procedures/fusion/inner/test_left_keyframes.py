"""How keyframes that have left a window err together: against the dense inverse of the whole problem."""

from itertools import pairwise

import numpy as np
import pytest

from procedures.fusion.inner.left_keyframes import Left, shares
from procedures.fusion.inner.window_factor import Factor
from procedures.fusion.inner.window_problem import Gone, Held
from procedures.fusion.inner.window_state import COMMON, FRAME, PLACE, WindowState

NOWHERE = WindowState(*(np.zeros(0) for _ in range(7)), 0.0, np.zeros(0))


@pytest.mark.parametrize("end", [3, 5, 6])
def test_the_share_of_a_step_is_its_covariance_with_the_way(end: int) -> None:
    frames, stay, rng = 7, 3, np.random.default_rng(1)
    whole = _chain(frames, rng)
    left, A = list[Left](), whole.copy()
    for _ in range(frames - stay):  # each keyframe stands behind the common numbers when it leaves
        own, others = slice(COMMON, COMMON + FRAME), np.r_[:COMMON, COMMON + FRAME : len(A)]
        near = others[: COMMON + FRAME]
        factor = Factor(A[own, own])
        by = factor.solve(np.column_stack((A[own, near], np.zeros(FRAME))))
        left.append(Left(NOWHERE, Held([], []), Gone(by, factor)))
        A = A[np.ix_(others, others)] - A[others, own] @ np.linalg.solve(A[own, own], A[own, others])
    found = shares(left, Factor(A), stay, end)
    P = np.linalg.inv(whole)
    places = [np.arange(COMMON + FRAME * k, COMMON + FRAME * (k + 1))[PLACE] for k in range(frames)]
    way = P[:, places[end]] - P[:, places[0]]
    expected = [way[there] - way[here] for here, there in pairwise(places)]
    assert found == pytest.approx(np.array(expected), rel=1e-8)
    total = way[places[end]] - way[places[0]]
    assert found[:end].sum(axis=0) == pytest.approx(total, rel=1e-8)


def _chain(frames: int, rng: np.random.Generator) -> np.ndarray:
    """Return normal equations of keyframes that are tied to the next and to what is common alone."""
    size = COMMON + FRAME * frames
    A = np.eye(size) * 1e-2
    for k in range(frames - 1):
        at = np.r_[:COMMON, COMMON + FRAME * k : COMMON + FRAME * (k + 2)]
        J = rng.normal(size=(FRAME, len(at)))
        A[np.ix_(at, at)] += J.T @ J
    return A
