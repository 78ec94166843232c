"""How a camera moved between two frames, up to scale: the essential matrix without outliers.

Han 2022 (III.A) uses seven points and pixels. With known intrinsics the eight-point equations are linear on the
plane at depth 1, and all trial samples are solved at once. Source of the method: Hartley, Zisserman, Multiple View
Geometry, 9.6 and 11.2.

`EpipolarRotations` rates given rotations of pairs of frames, whichever way the camera moved. A point stands at y0
and y1 (depth 1) in two frames, R turns axes of the first to the second, t is the translation up to scale:

    n = (R y0) x y1,   t' n = 0   (the epipolar constraint; Kneip, Lynen 2013)

so that all n of a pair lie in a plane, and the smallest eigenvalue of sum w n n' over t says how wrong R is. With
the noise of n, V = sum w cov(n), the problem is N t = lambda V t (Kanatani's renormalisation): the plain one takes
a small translation for one along the view. Each n is weighted by Sampson's variance and Geman's and McClure's
loss; as that has several minima where the translation is small, t is sought from three sides. Given t, the misfit
of a small remaining rotation phi of R is linear,

    e = t' n / s,   de/dphi = (R y0) x (y1 x t) / s,   de/dt = n / s,

and t is eliminated: the result is how each pair, alone, would turn R.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.frames import skew
from procedures.fusion.feature_tracks import FramePairs

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


LOSS_SIGMAS = 4.0  # sigmas of a point at which its weight has fallen to a quarter
ITERATIONS = 3
TINY = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class RotationMisfit:
    """Half the second derivative ``H`` (p, 3, 3) and gradient ``g`` (p, 3) of each pair's cost by a left turn."""

    H: FloatArray
    g: FloatArray


class EpipolarRotations:
    """Pairs of frames; ``std`` (2,) is 1 sigma of a point at depth 1, ``loss`` where the loss turns."""

    def __init__(
        self, pairs: FramePairs, std: FloatArray, loss: float = LOSS_SIGMAS, rounds: int = ITERATIONS
    ) -> None:
        self.pairs, self._variance, self._loss, self._rounds = pairs, std**2, loss, rounds

    def misfit(self, R: FloatArray) -> RotationMisfit:
        """Return the misfit of rotations ``R`` (p, 3, 3); each direction is sought from three sides."""
        u = self.pairs.y0 @ np.swapaxes(R, 1, 2)
        n = np.cross(u, self.pairs.y1)
        sides = self._sides(u, n)
        directions = np.array([self._settled(R, u, n, sides[:, :, i], 1) for i in range(3)])
        costs = np.array([self._cost(R, u, n, direction) for direction in directions])
        best = directions[costs.argmin(axis=0), np.arange(len(u))]
        return self._eliminated(R, u, n, self._settled(R, u, n, best, self._rounds - 1))

    def _sides(self, u: FloatArray, n: FloatArray) -> FloatArray:
        """Return three directions (p, 3, 3), columns, the likeliest first; normals far too long count little."""
        size, there = np.sum(n**2, axis=2), self.pairs.there
        usual = _medians(size, there)
        return self._ways(u, n, there / (1 + size / (4 * usual + TINY)) ** 2 / self._variance.sum())

    def _ways(self, u: FloatArray, n: FloatArray, w: FloatArray) -> FloatArray:
        """Solve N t = lambda V t for weights (p, k): unit vectors (p, 3, 3) in columns, lambda rising."""
        N, U = (np.swapaxes(a * w[:, :, None], 1, 2) @ a for a in (n, u))
        x, y = self._variance
        V = np.zeros_like(N)
        V[:, 0, 0], V[:, 1, 1] = y * U[:, 2, 2], x * U[:, 2, 2]
        V[:, 2, 2] = x * U[:, 1, 1] + y * U[:, 0, 0]
        V[:, 1, 2] = V[:, 2, 1] = -x * U[:, 1, 2]
        V[:, 0, 2] = V[:, 2, 0] = -y * U[:, 0, 2]
        size = np.trace(V, axis1=1, axis2=2)[:, None, None] + TINY
        L = np.linalg.inv(np.linalg.cholesky(V / size + TINY * np.eye(3)))
        _, X = np.linalg.eigh(L @ (N / size) @ np.swapaxes(L, 1, 2))
        directions: FloatArray = np.swapaxes(L, 1, 2) @ X
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        return directions

    def _settled(self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray, rounds: int) -> FloatArray:
        for _ in range(rounds):
            variance, e = self._whitened(R, u, n, t)
            t = self._ways(u, n, self._weight(e) / variance)[:, :, 0]
        return t

    def _whitened(
        self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return Sampson's variance (p, k) of the constraint, and the constraint in its sigmas (p, k)."""
        across = skew(t)
        l1, l0 = u @ across[:, :, :2], self.pairs.y1 @ (across @ R)[:, :, :2]  # lines, but for their signs
        variance = (l1 * l1 + l0 * l0) @ self._variance + TINY
        return variance, (n @ t[:, :, None])[:, :, 0] / np.sqrt(variance)

    def _weight(self, e: FloatArray) -> FloatArray:
        weight: FloatArray = self.pairs.there / (1 + (e / self._loss) ** 2) ** 2
        return weight

    def _cost(self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray) -> FloatArray:
        e2 = self._whitened(R, u, n, t)[1] ** 2
        cost: FloatArray = np.sum(self.pairs.there * e2 / (1 + e2 / self._loss**2), axis=1)
        return cost

    def _eliminated(self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray) -> RotationMisfit:
        variance, e = self._whitened(R, u, n, t)
        weight = (self._weight(e) / variance)[:, :, None]
        beside = np.linalg.svd(t[:, None])[2][:, 1:]
        by_turn = np.cross(u, self.pairs.y1 @ skew(t))
        J = np.concatenate((by_turn, n @ np.swapaxes(beside, 1, 2)), axis=2)
        back = np.swapaxes(J * weight, 1, 2)
        A, b = back @ J, (back @ (n @ t[:, :, None]))[:, :, 0]
        tied = A[:, :3, 3:] @ np.linalg.inv(A[:, 3:, 3:] + TINY * np.eye(2))
        g = b[:, :3] - (tied @ b[:, 3:, None])[:, :, 0]
        return RotationMisfit(A[:, :3, :3] - tied @ A[:, 3:, :3], g)


def _medians(values: FloatArray, there: FloatArray) -> FloatArray:
    """Return the median (p, 1) of what is there of each row (p, k)."""
    counts = there.sum(axis=1).astype(np.int64)
    risen = np.sort(np.where(there > 0, values, np.inf), axis=1)
    medians: FloatArray = risen[np.arange(len(risen)), counts // 2][:, None]
    return medians
