"""Landmarks seen from keyframes: residuals, derivatives, and the landmarks' elimination (Schur complement).

A landmark is a ray and an inverse depth from where it was first seen, as Han has it (eq. 5), but from a *fixed*
point a and fixed axes A, not from an estimated keyframe: (x, y, rho) are then merely coordinates of the point
``a + A (x, y, 1) / rho``, good for near and far, and survive the keyframe. In the camera of keyframe k

    y = C_bc' (C_k' (rho (a - p_k) + A (x, y, 1)) - rho t_bc),   r = (fx, fy) / std (y_12 / y_3 - z)

which is finite for a point at infinity. Where the camera's time offset d is not given, C_k and p_k are those of
the moment at which the frame was truly taken, C_k exp(d [w_k]x) and p_k + d v_k (Li, Mourikis 2014; Qin, Shen
2018 move the image point instead). Where a camera has a rolling shutter, of which each row is taken r later than
the one above it, d is that of the row, d + r fy z_2: rows have moments of their own (Li, Kim, Mourikis 2013).
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.frames import skew
from procedures.fusion.inner.window_state import WindowState

HUBER = 2.0  # of a whitened image point (two axes)
SEEING = 7  # numbers of the camera: turn, shift, time offset
CLOSEST = 0.02  # of rho times depth: nearer to the camera's plane, or behind it, says nothing


@dataclass(frozen=True, slots=True, eq=False)
class Sights:
    """Landmarks and where they were seen: ``a`` (l, 3) [m], ``A`` (l, 3, 3), ``at`` (l, 3) the coordinates,
    ``z`` (i, k, 2) on the plane at depth 1, ``seen`` (i, k).
    """  # noqa: D205

    a: FloatArray
    A: FloatArray
    at: FloatArray
    z: FloatArray
    seen: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class Visual:
    """Normal equations of sights: poses ``H`` (7 + 6 k square: camera and offset, keyframes) with ``g``, ties
    ``W`` (l, 3, 7 + 6 k), landmarks ``L`` (l, 3, 3) with ``b`` (l, 3).
    """  # noqa: D205

    H: FloatArray
    g: FloatArray
    W: FloatArray
    L: FloatArray
    b: FloatArray


def residuals(
    state: WindowState, s: Sights, scale: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
    """Return landmark and keyframe (m,) of each sight, residuals (m, 2) whitened by ``scale`` (2,), y (m, 3)."""
    i, k = np.nonzero(s.seen)
    ray = np.column_stack((s.at[:, :2], np.ones(len(s.at))))
    far = np.einsum("lij,lj->li", s.A, ray)
    rho = s.at[i, 2:]
    C_ob, p = state.seen_from(k, s.z[i, k, 1])
    y_b = np.einsum("mji,mj->mi", C_ob, rho * (s.a[i] - p) + far[i])
    y = (y_b - rho * state.t_bc) @ state.C_bc
    r = scale * (y[:, :2] / np.maximum(y[:, 2:], CLOSEST) - s.z[i, k])
    return i, k, r, y


def linearise(state: WindowState, s: Sights, scale: FloatArray) -> Visual:
    """Return the normal equations; ``scale`` (2,) is focal length over sigma, each sight weighted by Huber."""
    i, k, r, y = residuals(state, s, scale)
    front = y[:, 2] > CLOSEST
    i, k, r, y = i[front], k[front], r[front], y[front]
    weight = np.sqrt(HUBER / np.maximum(np.linalg.norm(r, axis=1), HUBER))[:, None]
    pose, point = _jacobians(state, s, scale, i, k, y, weight)
    return _normal(s, len(state.p), i, k, r * weight, pose, point)


def _jacobians(
    state: WindowState,
    s: Sights,
    scale: FloatArray,
    i: IntArray,
    k: IntArray,
    y: FloatArray,
    weight: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the weighted derivatives (m, 2, 13) by camera and keyframe, and (m, 2, 3) by the landmark."""
    rho, depth = s.at[i, 2], y[:, 2]
    P = np.zeros((len(i), 2, 3))
    P[:, range(2), range(2)] = scale * weight / depth[:, None]
    P[:, :, 2] = -P[:, range(2), range(2)] * y[:, :2] / depth[:, None]
    PC = P @ state.C_bc.T
    C_ob, p = state.seen_from(k, s.z[i, k, 1])
    PCC = PC @ np.swapaxes(C_ob, 1, 2)
    y_b = y @ state.C_bc.T + rho[:, None] * state.t_bc
    turn, place = PC @ skew(y_b), -rho[:, None, None] * PCC
    rate, v = state.swept()
    late = turn @ rate[k][:, :, None] + place @ v[k][:, :, None]
    pose = np.concatenate((P @ skew(y), -rho[:, None, None] * PC, late, turn, place), axis=2)
    p_c = p + C_ob @ state.t_bc
    along = (PCC @ (s.a[i] - p_c)[:, :, None])[:, :, 0]
    return pose, np.concatenate((PCC @ s.A[i][:, :, :2], along[:, :, None]), axis=2)


def _normal(
    s: Sights,
    frames: int,
    i: IntArray,
    k: IntArray,
    r: FloatArray,
    pose: FloatArray,
    point: FloatArray,
) -> Visual:
    count, size = len(s.at), SEEING + 6 * frames
    H, g, W = np.zeros((size, size)), np.zeros(size), np.zeros((count, 3, size))
    J = np.concatenate((pose, r[:, :, None], point), axis=2)
    order, ends = np.argsort(k, kind="stable"), 2 * np.cumsum(np.bincount(k, minlength=frames))
    rows = J[order, :, :14].reshape(-1, 14)  # keyframe by keyframe
    square = np.array([part.T @ part for part in np.split(rows, ends[:-1])])
    ties = square[:, SEEING:13, :SEEING].reshape(-1, SEEING)
    H[:SEEING, :SEEING] = square[:, :SEEING, :SEEING].sum(axis=0)
    H[SEEING:, :SEEING], H[:SEEING, SEEING:] = ties, ties.T
    blocks = H[SEEING:, SEEING:].reshape(frames, 6, frames, 6)
    np.einsum("iaib->iab", blocks)[:] = square[:, SEEING:13, SEEING:13]  # a view of those on the diagonal
    g[:SEEING], g[SEEING:] = square[:, :SEEING, 13].sum(axis=0), square[:, SEEING:13, 13].ravel()
    tied = np.swapaxes(point, 1, 2) @ J
    W[:, :, SEEING:].reshape(count, 3, frames, 6)[i, :, k] = tied[:, :, SEEING:13]
    marks = _summed(tied, i, count)
    W[:, :, :SEEING] = marks[:, :, :SEEING]
    return Visual(H, g, W, marks[:, :, 14:], marks[:, :, 13])


def _summed(parts: FloatArray, i: IntArray, count: int) -> FloatArray:
    """Return sums (count, ...) of rows (m, ...) over each landmark; ``i`` does not fall."""
    total = np.zeros((count, *parts.shape[1:]))
    if len(i):
        first = np.flatnonzero(np.diff(i, prepend=-1) > 0)
        total[i[first]] = np.add.reduceat(parts, first)
    return total
