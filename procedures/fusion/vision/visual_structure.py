"""Where a camera was over some frames, up to scale, from tracks alone (Han 2022 III.A less its scale).

Two frames far enough apart give the first motion; the points they share give the other frames; then all frames and
points are fitted together (bundle adjustment with Huber's loss, sights that are no match not used).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import FloatArray, IntArray
from procedures.frames import rotation, wahba_rotation
from procedures.fusion.inner.landmarks import CAMERA_NUMBERS, Landmarks, linearise, residuals
from procedures.fusion.inner.window_state import WindowState
from procedures.fusion.vision.two_view import MIN_POINTS, two_view

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
    s = marks.sights
    last = len(t) - 1
    both = s.seen[:, 0] & s.seen[:, last]
    if both.sum() < MIN_POINTS:
        return f"{both.sum()} features are followed over {t[-1] - t[0]:.1f} s, {MIN_POINTS} are needed"
    x0, x1 = s.z[both, 0], s.z[both, last]
    if (bent := _parallax(x0, x1, _turn(x0, x1)) * float(scale.mean())) < MIN_BEND_SIGMAS:
        least = f"{MIN_BEND_SIGMAS:.0f} are needed: move further"
        return f"the image moves by {bent:.1f} sigmas more than by a turn, {least}"
    found = two_view(x0, x1, EPIPOLAR_SIGMAS / float(scale.mean()), rng)
    if found is None:
        return "the features' motion does not match one camera in a static scene"
    parallax = _parallax(x0, x1, found.C_01) * float(scale.mean())
    if parallax < MIN_PARALLAX_SIGMAS:
        least = f"{MIN_PARALLAX_SIGMAS:.0f} are needed: move further"
        return f"the parallax is {parallax:.0f} sigmas of an image point, {least}"
    state = _between(t, found.C_01, found.p_0)
    _resect(state, marks, np.flatnonzero(both)[found.agree], scale)
    return _adjusted(state, marks, scale)


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
