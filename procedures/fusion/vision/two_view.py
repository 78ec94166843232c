"""How a camera moved between two frames, up to scale: the essential matrix without outliers.

Eight-point equations on the plane at depth 1 (Hartley, Zisserman, Multiple View Geometry, 9.6 and 11.2; Han 2022,
III.A, has seven points).

`EpipolarRotations` rates given rotations of pairs of frames, whichever way the camera moved. A point stands at y0
and y1 (depth 1) in two frames, R turns axes of the first to the second, t is the translation up to scale:

    n = (R y0) x y1,   t' n = 0   (the epipolar constraint; Kneip, Lynen 2013)

so that all n of a pair lie in a plane. With N = sum w n n' and the noise of n, V = sum w cov(n), t is that of the
least lambda in N t = lambda V t (Kanatani's renormalisation). Each n is weighted by Sampson's variance and Geman's
and McClure's loss; as that has several minima, t is sought from three sides. Given t, the misfit of a small
remaining rotation phi of R is linear,

    e = t' n / s,   de/dphi = (R y0) x (y1 x t) / s,   de/dt = n / s,

and t is eliminated: the result is how each pair, alone, would turn R.

The camera's path over some frames, up to scale, follows from tracks alone (Han 2022 III.A less its scale): two
frames far enough apart give the first motion; the points they share give the other frames; then all frames and
points are fitted together (bundle adjustment with Huber's loss, sights that are no match not used).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.frames import rotation, skew, wahba_rotation
from procedures.fusion.feature_tracks import FramePairs
from procedures.fusion.inner.landmarks import CAMERA_NUMBERS, Landmarks, linearise, residuals
from procedures.fusion.inner.window_state import WindowState

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
        return self.pairs.there / (1 + (e / self._loss) ** 2) ** 2

    def _cost(self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray) -> FloatArray:
        e2 = self._whitened(R, u, n, t)[1] ** 2
        cost: FloatArray = np.sum(self.pairs.there * e2 / (1 + e2 / self._loss**2), axis=1)
        return cost

    def _eliminated(self, R: FloatArray, u: FloatArray, n: FloatArray, t: FloatArray) -> RotationMisfit:
        variance, e = self._whitened(R, u, n, t)
        weight = (self._weight(e) / variance)[:, :, None]
        across = np.linalg.svd(t[:, None])[2][:, 1:]
        by_turn = np.cross(u, self.pairs.y1 @ skew(t))
        J = np.concatenate((by_turn, n @ np.swapaxes(across, 1, 2)), axis=2)
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


MIN_BEND_SIGMAS = 4.0  # sigmas of an image point that no mere turn explains, median
MIN_PARALLAX_SIGMAS = 20.0  # sigmas of an image point, median over what two frames share, rotation removed
EPIPOLAR_SIGMAS = 2.0  # sigmas from the epipolar line
OUTLIER_SIGMAS = 4.0  # whitened length of a sight that is no match
MAX_ITERATIONS = 10
DAMPING = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class CameraStructure:
    """Cameras ``C_0c`` (k, 3, 3) and ``p_0`` (k, 3) in the axes of the first, in a unit of its own.

    ``misfit`` is the mean square of the whitened sights over what noise gives.
    """

    C_0c: FloatArray
    p_0: FloatArray
    misfit: float


def structure(
    marks: Landmarks, t: FloatArray, scale: FloatArray, rng: np.random.Generator
) -> CameraStructure | str:
    """Return the cameras at ``t`` (k,) [s] from the landmarks of ``marks``, which are placed; or what is missing.

    ``scale`` (2,) is focal length over sigma.
    """
    s, sigmas = marks.sights, float(scale.mean())
    both = s.seen[:, 0] & s.seen[:, -1]
    if both.sum() < MIN_POINTS:
        return f"{both.sum()} features are followed over {t[-1] - t[0]:.1f} s, {MIN_POINTS} are needed"
    x0, x1 = s.z[both, 0], s.z[both, -1]
    if (bent := _parallax(x0, x1, _turn(x0, x1)) * sigmas) < MIN_BEND_SIGMAS:
        return f"the image moves by {bent:.1f} sigmas more than by a turn, {_required(MIN_BEND_SIGMAS)}"
    found = two_view(x0, x1, EPIPOLAR_SIGMAS / sigmas, rng)
    if found is None:
        return "the features' motion does not match one camera in a static scene"
    if (parallax := _parallax(x0, x1, found.C_01) * sigmas) < MIN_PARALLAX_SIGMAS:
        return f"the parallax is {parallax:.0f} sigmas of an image point, {_required(MIN_PARALLAX_SIGMAS)}"
    state = _between(t, found.C_01, found.p_0)
    _resect(state, marks, np.flatnonzero(both)[found.agree], scale)
    return _adjusted(state, marks, scale)


def _required(sigmas: float) -> str:
    return f"{sigmas:.0f} are needed: move further"


def _parallax(x0: FloatArray, x1: FloatArray, C_01: FloatArray) -> float:
    y = np.column_stack((x1, np.ones(len(x1)))) @ C_01.T
    return float(np.median(np.linalg.norm(y[:, :2] / np.maximum(y[:, 2:], 0.1) - x0, axis=1)))


def _turn(x0: FloatArray, x1: FloatArray) -> FloatArray:
    """Return the rotation that takes the rays (n, 2) of the second frame onto those of the first best."""
    y0, y1 = (np.column_stack((x, np.ones(len(x)))) for x in (x0, x1))
    y0, y1 = (y / np.linalg.norm(y, axis=1)[:, None] for y in (y0, y1))
    weight, C = np.ones(len(x0)), np.eye(3)
    for _ in range(3):  # the few that are no match lose their weight
        C = wahba_rotation((y0 * weight[:, None]).T @ y1)
        off = np.linalg.norm(y0 - y1 @ C.T, axis=1)
        weight = 1 / np.maximum(off, max(float(np.median(off)), 1e-9))
    return C


def _between(t: FloatArray, C_01: FloatArray, p_0: FloatArray) -> WindowState:
    """Return frames between the two that are known, as on a straight path."""
    share = (t - t[0]) / (t[-1] - t[0])
    C = Slerp([0.0, 1.0], Rotation.from_matrix([np.eye(3), C_01]))(share).as_matrix()
    none = np.zeros((len(t), 3))
    return WindowState(C, share[:, None] * p_0, none, none, none, np.eye(3), np.zeros(3), 0.0, np.zeros((0, 3)))


def _resect(state: WindowState, marks: Landmarks, rows: IntArray, scale: FloatArray) -> None:
    """Move the frames between first and last to where ``rows``, placed by those two, are seen from."""
    s = marks.sights
    ends = s.seen.copy()
    ends[:, 1:-1] = False
    only = np.zeros(len(s.at), bool)
    only[rows] = True
    marks.sights = replace(s, seen=ends & only[:, None])
    marks.settle(state)
    inner = np.arange(1, len(state.p) - 1)
    marks.sights = replace(s, seen=s.seen & only[:, None])
    for _ in range(MAX_ITERATIONS):
        visual = linearise(state, marks.sights, scale)
        for k in inner:
            at = slice(CAMERA_NUMBERS + 6 * k, CAMERA_NUMBERS + 6 * k + 6)
            H = visual.H[at, at]
            damped = H + DAMPING * np.diag(np.diag(H)) + np.eye(6)
            step: FloatArray = np.asarray(-np.linalg.solve(damped, visual.g[at]), np.float64)
            state.C_ob[k] = state.C_ob[k] @ rotation(step[:3])
            state.p[k] += step[3:]
    marks.sights = s


def _adjusted(state: WindowState, marks: Landmarks, scale: FloatArray) -> CameraStructure | str:
    """Fit all frames and landmarks; the first frame stands, and the distance of the last from it."""
    marks.settle(state)
    marks.sights = replace(marks.sights, seen=marks.sights.seen & marks.ready[:, None])
    for strictness in (4 * OUTLIER_SIGMAS, OUTLIER_SIGMAS, OUTLIER_SIGMAS):
        state = _fitted(state, marks, scale)
        rows, frames, r, y = residuals(state, marks.sights, scale)
        bad = (np.linalg.norm(r, axis=1) > strictness) | (y[:, 2] <= 0)
        marks.sights.seen[rows[bad], frames[bad]] = False
    if marks.sights.seen[:, -1].sum() < MIN_POINTS:
        return "too few features fit one motion of the camera"
    freedom = 2 * (~bad).sum() - 3 * marks.sights.seen.any(axis=1).sum() - 6 * len(state.p)
    return CameraStructure(state.C_ob, state.p, float(np.sum(r[~bad] ** 2)) / max(int(freedom), 1))


def _fitted(state: WindowState, marks: Landmarks, scale: FloatArray) -> WindowState:
    """Return the state after some rounds of Levenberg and Marquardt, the landmarks moved with it."""
    free = np.arange(CAMERA_NUMBERS + 6, CAMERA_NUMBERS + 6 * len(state.p))
    along = CAMERA_NUMBERS + 6 * (len(state.p) - 1) + 3 + int(np.abs(state.p[-1]).argmax())
    free = free[free != along]
    for _ in range(MAX_ITERATIONS):
        visual = linearise(state, marks.sights, scale)
        L = visual.L + np.diag([1e-2, 1e-2, 1e-4]) + DAMPING * visual.L * np.eye(3)
        inverse = np.asarray(np.linalg.inv(L), np.float64)
        W = visual.W[:, :, free]
        WL = inverse @ W
        flat = WL.reshape(-1, len(free))
        A = visual.H[np.ix_(free, free)] - W.reshape(-1, len(free)).T @ flat
        A[range(len(free)), range(len(free))] *= 1 + DAMPING
        step = np.zeros(visual.H.shape[0])
        step[free] = -np.linalg.solve(A, visual.g[free] - flat.T @ visual.b.ravel())
        moves = -(inverse @ (visual.b + W @ step[free])[:, :, None])[:, :, 0]
        every = np.zeros(state.size)
        for k in range(len(state.p)):
            every[state.frame(k)][:6] = step[CAMERA_NUMBERS + 6 * k : CAMERA_NUMBERS + 6 * k + 6]
        state = state.moved(every)
        marks.step(np.ones(len(moves), bool), moves, state.held)
        if np.abs(step).max() < 1e-5:
            break
    return state
