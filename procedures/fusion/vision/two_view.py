"""How a camera moved between two frames, up to scale: the essential matrix, outliers left out.

Han 2022 (III.A) uses seven points and pixels. With known intrinsics the eight-point equations are linear on the
plane at depth 1, and all trial samples are solved at once. Source of the method: Hartley, Zisserman, Multiple View
Geometry, 9.6 and 11.2.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray

RANSAC_TRIALS = 300
SAMPLE_POINTS = 12  # a trial: eight fix the matrix, but hardly under noise; nine good ones where 1 in 4 is wrong
LIMIT_FACTORS = (3.0, 2.0, 1.5, 1.0)  # of the limit, while a sample's motion becomes that of all
MIN_POINTS = 20  # points of which a motion is believed


@dataclass(frozen=True, slots=True, eq=False)
class TwoView:
    """Camera 1 in the axes of camera 0: ``C_01`` (3, 3), unit ``p_0`` (3,), and which points agree (n,)."""

    C_01: FloatArray
    p_0: FloatArray
    agree: BoolArray


def two_view(x0: FloatArray, x1: FloatArray, limit: float, rng: np.random.Generator) -> TwoView | None:
    """Return the motion that most of the points ``x0``, ``x1`` (n, 2) in both frames agree with, or None.

    ``limit`` is how far off a point may lie, in units of the plane at depth 1; ``rng`` draws the samples.
    """
    if len(x0) < MIN_POINTS:
        return None
    y0, y1 = (np.column_stack((x, np.ones(len(x)))) for x in (x0, x1))
    pick = np.argsort(rng.random((RANSAC_TRIALS, len(x0))), axis=1)[:, :SAMPLE_POINTS]
    E = _essential(y0[pick], y1[pick])
    agree = sampson_distance(E, y0, y1) < LIMIT_FACTORS[0] * limit
    best = agree[agree.sum(axis=1).argmax()]
    for wider in LIMIT_FACTORS:
        if best.sum() < MIN_POINTS:
            return None
        E = _essential(y0[best][None], y1[best][None])
        best = sampson_distance(E, y0, y1)[0] < wider * limit
    return _before_both(E[0], y0, y1, best)


def _essential(y0: FloatArray, y1: FloatArray) -> FloatArray:
    """Return matrices (s, 3, 3) with ``y1' E y0 = 0`` over sets of points (s, n, 3) by least squares."""
    rows = (y1[..., :, None] * y0[..., None, :]).reshape(*y0.shape[:-1], 9)
    _, vectors = np.linalg.eigh(np.swapaxes(rows, -1, -2) @ rows)
    U, _, Vt = np.linalg.svd(vectors[..., 0].reshape(-1, 3, 3))
    E: FloatArray = U @ np.diag([1.0, 1.0, 0.0]) @ Vt
    return E


def sampson_distance(E: FloatArray, y0: FloatArray, y1: FloatArray) -> FloatArray:
    """Return Sampson's distance (s, n), in units of the plane at depth 1.

    Parameters
    ----------
    E : (s, 3, 3)
        Essential matrices.
    y0, y1 : (n, 3)
        The points at depth 1 in both frames.
    """
    l1, l0 = y0 @ np.swapaxes(E, -1, -2), y1 @ E
    off = np.abs(np.sum(l1 * y1, axis=-1))
    distance: FloatArray = off / np.sqrt(np.sum(l1[..., :2] ** 2 + l0[..., :2] ** 2, axis=-1))
    return distance


def _before_both(E: FloatArray, y0: FloatArray, y1: FloatArray, agree: BoolArray) -> TwoView | None:
    """Return that of the four motions of E for which the points lie before both cameras."""
    U, _, Vt = np.linalg.svd(E)
    U, Vt = U * np.linalg.det(U), Vt * np.linalg.det(Vt)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = [(U @ W @ Vt, side * U[:, 2]) for W in (turn, turn.T) for side in (1.0, -1.0)]
    counts = [_in_front(R, t, y0[agree], y1[agree]) for R, t in found]
    best = int(np.argmax(counts))
    if counts[best] < max(MIN_POINTS, 0.7 * agree.sum()):
        return None
    R, t = found[best]  # y1 ~ R y0 + t
    return TwoView(R.T, -R.T @ t, agree)


def _in_front(R: FloatArray, t: FloatArray, y0: FloatArray, y1: FloatArray) -> int:
    """Return how many points have positive depths a, b in ``b y1 = a R y0 + t``."""
    u = y0 @ R.T
    uu, uv, vv = (np.sum(p * q, axis=1) for p, q in ((u, u), (u, y1), (y1, y1)))
    ut, vt = u @ t, y1 @ t
    a, b = uv * vt - vv * ut, uu * vt - uv * ut
    return int(np.count_nonzero((a > 0) & (b > 0)))
