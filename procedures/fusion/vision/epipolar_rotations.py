r"""How well turns between pairs of frames fit what a camera saw in both, whichever way it moved meanwhile.

A point stands at y0 and y1 (depth 1) in two frames, R turns axes of the first to the second, t is the way between
them up to scale:

    n = (R y0) x y1,   t' n = 0   (the epipolar constraint; Kneip, Lynen 2013)

so that all n of a pair lie in a plane, and the smallest eigenvalue of sum w n n' over t says how wrong R is. With
the noise of n, V = sum w cov(n), the problem is N t = lambda V t (Kanatani's renormalisation): the plain one takes
a small way for one along the view. Each n is weighted by Sampson's variance and Geman's and McClure's loss; as
that has several valleys where the way is small, t is sought from three sides. Given t, the misfit of a small left
turn phi of R is linear,

    e = t' n / s,   de/dphi = (R y0) x (y1 x t) / s,   de/dt = n / s,

and t is eliminated: what stays is how each pair, alone, would turn R.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.frames import skew
from procedures.fusion.vision.frame_pairs import FramePairs

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
        """Return the misfit of rotations ``R`` (p, 3, 3); the way of each pair is sought from three sides."""
        u = self.pairs.y0 @ np.swapaxes(R, 1, 2)
        n = np.cross(u, self.pairs.y1)
        sides = self._sides(u, n)
        ways = np.array([self._settled(R, u, n, sides[:, :, i], 1) for i in range(3)])
        costs = np.array([self._cost(R, u, n, way) for way in ways])
        best = ways[costs.argmin(axis=0), np.arange(len(u))]
        return self._eliminated(R, u, n, self._settled(R, u, n, best, self._rounds - 1))

    def _sides(self, u: FloatArray, n: FloatArray) -> FloatArray:
        """Return three ways (p, 3, 3), in columns, the likeliest first; normals far too long count little."""
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
        ways: FloatArray = np.swapaxes(L, 1, 2) @ X
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        return ways

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
