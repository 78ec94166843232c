"""Landmarks of a window seen from keyframes: residuals, derivatives, and their elimination (Schur complement).

A landmark is a ray and an inverse depth from where it was first seen, as Han has it (eq. 5), but from a *fixed*
point a and fixed axes A, not from an estimated keyframe: (x, y, rho) are then merely coordinates of the point
``a + A (x, y, 1) / rho``, good for near and far, and survive the keyframe. In the camera of keyframe k

    y = C_bc' (C_k' (rho (a - p_k) + A (x, y, 1)) - rho t_bc),   r = (fx, fy) / std (y_12 / y_3 - z)

which is finite for a point at infinity. Where the camera's time offset d is not given, C_k and p_k are those of
the moment at which the frame was truly taken, C_k exp(d [w_k]x) and p_k + d v_k (Li, Mourikis 2014). Of a rolling
shutter, of which each row is taken r later than the one above it, d is d + r fy z_2 (Li, Kim, Mourikis 2013).
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.frames import skew
from procedures.fusion.inner.window_state import WindowState

HUBER_LIMIT = 2.0  # of a whitened image point (two axes)
CAMERA_NUMBERS = 7  # numbers of the camera: turn, shift, time offset
MIN_RELATIVE_DEPTH = 0.02  # of rho times depth: nearer to the camera's plane, or behind it, says nothing


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
    r = scale * (y[:, :2] / np.maximum(y[:, 2:], MIN_RELATIVE_DEPTH) - s.z[i, k])
    return i, k, r, y


def linearise(state: WindowState, s: Sights, scale: FloatArray) -> Visual:
    """Return the normal equations; ``scale`` (2,) is focal length over sigma, each sight weighted by Huber."""
    i, k, r, y = residuals(state, s, scale)
    front = y[:, 2] > MIN_RELATIVE_DEPTH
    i, k, r, y = i[front], k[front], r[front], y[front]
    weight = np.sqrt(HUBER_LIMIT / np.maximum(np.linalg.norm(r, axis=1), HUBER_LIMIT))[:, None]
    pose, point = _jacobians(state, s, scale, i, k, y, weight)
    return _normal(s, len(state.p), i, k, r * weight, pose, point)


def _jacobians(
    state: WindowState, s: Sights, scale: FloatArray, i: IntArray, k: IntArray, y: FloatArray, weight: FloatArray
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
    s: Sights, frames: int, i: IntArray, k: IntArray, r: FloatArray, pose: FloatArray, point: FloatArray
) -> Visual:
    count, size = len(s.at), CAMERA_NUMBERS + 6 * frames
    H, g, W = np.zeros((size, size)), np.zeros(size), np.zeros((count, 3, size))
    J = np.concatenate((pose, r[:, :, None], point), axis=2)
    order, ends = np.argsort(k, kind="stable"), 2 * np.cumsum(np.bincount(k, minlength=frames))
    rows = J[order, :, :14].reshape(-1, 14)  # keyframe by keyframe
    square = np.array([part.T @ part for part in np.split(rows, ends[:-1])])
    camera, own = slice(CAMERA_NUMBERS), slice(CAMERA_NUMBERS, 13)
    ties = square[:, own, camera].reshape(-1, CAMERA_NUMBERS)
    H[camera, camera] = square[:, camera, camera].sum(axis=0)
    H[CAMERA_NUMBERS:, camera], H[camera, CAMERA_NUMBERS:] = ties, ties.T
    blocks = H[CAMERA_NUMBERS:, CAMERA_NUMBERS:].reshape(frames, 6, frames, 6)
    np.einsum("iaib->iab", blocks)[:] = square[:, own, own]  # a view of those on the diagonal
    g[camera], g[CAMERA_NUMBERS:] = square[:, camera, 13].sum(axis=0), square[:, own, 13].ravel()
    tied = np.swapaxes(point, 1, 2) @ J
    W[:, :, CAMERA_NUMBERS:].reshape(count, 3, frames, 6)[i, :, k] = tied[:, :, own]
    marks = _summed(tied, i, count)
    W[:, :, camera] = marks[:, :, camera]
    return Visual(H, g, W, marks[:, :, 14:], marks[:, :, 13])


def _summed(parts: FloatArray, i: IntArray, count: int) -> FloatArray:
    """Return sums (count, ...) of rows (m, ...) over each landmark; ``i`` does not fall."""
    total = np.zeros((count, *parts.shape[1:]))
    if len(i):
        first = np.flatnonzero(np.diff(i, prepend=-1) > 0)
        total[i[first]] = np.add.reduceat(parts, first)
    return total


DEFAULT_INVERSE_DEPTH = 0.1  # 1/m, inverse depth of a landmark whose sights do not say
LOST = -1  # feature number of a landmark that is not followed any more
FREE = -1  # slot of a landmark that the prior does not hold
MIN_INVERSE_DEPTH, MAX_INVERSE_DEPTH = 1e-3, 20.0  # 1/m
MIN_PARALLAX = 0.01  # of parallax, below which sights do not say how far
MIN_MOTION_SIGMAS = 4.0  # sigmas of an image point by which a landmark moves more than by a turn, or
MIN_CAMERA_MOTION_M = 0.5  # m by which the camera has moved, before sights are used: see `Landmarks.settle`


class Landmarks:
    """Rows of landmarks, columns of keyframes; ``slot`` (l,) is the row in the state's ``held``, or `FREE`."""

    def __init__(self) -> None:
        self.feature = np.zeros(0, np.int64)
        self.slot = np.zeros(0, np.int64)
        self.ready = np.zeros(0, bool)
        none = np.zeros((0, 3))
        self.sights = Sights(none, np.zeros((0, 3, 3)), none, np.zeros((0, 0, 2)), np.zeros((0, 0), bool))

    def add_frame(self, feature: IntArray, rays: FloatArray) -> None:
        """Add a keyframe: numbers ``feature`` (m,) at ``rays`` (m, 2), z = 1; what is not among them is lost.

        One without a frame loses nothing: what is followed may be seen again, or come in late.
        """
        s = self.sights
        z = np.concatenate((s.z, np.zeros((len(s.at), 1, 2))), axis=1)
        self.sights = replace(s, z=z, seen=np.column_stack((s.seen, np.zeros(len(s.at), bool))))
        if len(feature):
            self.see(-1, feature, rays)

    def see(self, frame: int, feature: IntArray, rays: FloatArray) -> None:
        """Add numbers ``feature`` (m,) at ``rays`` (m, 2), z = 1, to keyframe ``frame``, the last to see any."""
        self.feature[~np.isin(self.feature, feature)] = LOST
        self._add_rows(feature[~np.isin(feature, self.feature)])
        order = np.argsort(self.feature, kind="stable")
        rows = order[np.searchsorted(self.feature[order], feature)]
        self.sights.z[rows, frame], self.sights.seen[rows, frame] = rays, True

    def lose_unseen(self) -> None:
        """Take for lost what no keyframe but the oldest, which is about to leave, has seen."""
        self.feature[~self.sights.seen[:, 1:].any(axis=1)] = LOST

    def settle(self, state: WindowState, scale: FloatArray | None = None) -> None:
        """Give each landmark that now has two sights a first place, by the keyframes as they are known.

        With ``scale`` (2,), focal length over sigma, it must have moved in the image, or the camera by much: at
        rest the distance of a landmark is not observable, and one that does not move on a path of noise looks
        infinitely far.
        """
        new = np.flatnonzero(~self.ready & (self.sights.seen.sum(axis=1) > 1))
        C_ob, p = state.exposed()
        C_oc, p_c = C_ob @ state.C_bc, p + C_ob @ state.t_bc
        if scale is not None:
            new = new[_moved(self.sights, new, C_oc, p_c, scale)]
        if not len(new):
            return
        s, first = self.sights, self.sights.seen[new].argmax(axis=1)
        s.a[new], s.A[new] = p_c[first], C_oc[first]
        s.at[new, :2] = s.z[new, first]
        s.at[new, 2] = _inverse_depth(s, new, C_oc, p_c)
        self.ready[new] = True

    def keep(self, which: BoolArray) -> None:
        """Forget all rows but those of ``which`` (l,), true or false."""
        self.feature, self.slot, self.ready = self.feature[which], self.slot[which], self.ready[which]
        self.sights = Sights(*(getattr(self.sights, each.name)[which] for each in fields(Sights)))

    def drop_first_frame(self) -> None:
        """Forget the oldest keyframe, and landmarks of which nothing is left."""
        s = self.sights
        self.sights = replace(s, z=s.z[:, 1:], seen=s.seen[:, 1:])
        self.keep(self.sights.seen.any(axis=1) | (self.slot != FREE))

    def reject(self, rows: IntArray, frames: IntArray) -> None:
        """Forget sights by indices ``rows`` (m,) and ``frames`` (m,); with that of the newest frame it is lost."""
        newest = np.flatnonzero(self.sights.seen.any(axis=0))[-1:]
        self.sights.seen[rows, frames] = False
        self.feature[rows[np.isin(frames, newest)]] = LOST

    def step(self, rows: BoolArray, step: FloatArray, held: FloatArray) -> None:
        """Move the free landmarks and set those that the prior holds.

        Parameters
        ----------
        rows : (l,), true where a landmark moves
        step : (m, 3), of those m: ray x, ray y, inverse distance [1/m]
        held : (h, 3), the same numbers of those that are held, by slot
        """
        at = self.sights.at
        at[rows] += step
        at[:, 2] = np.clip(at[:, 2], MIN_INVERSE_DEPTH, MAX_INVERSE_DEPTH)
        fixed = self.slot != FREE
        at[fixed] = held[self.slot[fixed]]

    def _add_rows(self, feature: IntArray) -> None:
        n = len(feature)
        self.feature = np.concatenate((self.feature, feature))
        self.slot = np.concatenate((self.slot, np.full(n, FREE)))
        self.ready = np.concatenate((self.ready, np.zeros(n, bool)))
        known = [getattr(self.sights, each.name) for each in fields(Sights)]
        self.sights = Sights(*(np.concatenate((x, np.zeros((n, *x.shape[1:]), x.dtype))) for x in known))


def _moved(s: Sights, rows: IntArray, C_oc: FloatArray, p_c: FloatArray, scale: FloatArray) -> BoolArray:
    """Return which rows (n,) are seen from far apart, or moved in the image more than the camera's turns explain.

    Two sights must have moved against the first, and two against the last: one alone may be no match.
    """
    seen, z = s.seen[rows], s.z[rows]
    first, last = seen.argmax(axis=1), seen.shape[1] - 1 - seen[:, ::-1].argmax(axis=1)
    far = (seen & (np.linalg.norm(p_c[None] - p_c[first][:, None], axis=2) > MIN_CAMERA_MOTION_M)).any(axis=1)
    ray = np.concatenate((z, np.ones((*seen.shape, 1))), axis=2)
    counts = []
    for ref in (first, last):
        there = np.einsum("lij,lj->li", C_oc[ref], ray[np.arange(len(rows)), ref])
        y = np.einsum("kji,lj->lki", C_oc, there)
        off = scale * (y[:, :, :2] / np.maximum(y[:, :, 2:], MIN_PARALLAX) - z)
        counts.append((seen & (np.linalg.norm(off, axis=2) > MIN_MOTION_SIGMAS)).sum(axis=1))
    moved: BoolArray = far | (np.minimum(*counts) >= 2)
    return moved


def _inverse_depth(s: Sights, rows: IntArray, C_oc: FloatArray, p_c: FloatArray) -> FloatArray:
    """Return inverse depths (n,) by least squares: ``z_k (y_3) - y_12 = 0`` is linear in them."""
    ray = np.einsum("lij,lj->li", s.A[rows], np.column_stack((s.at[rows, :2], np.ones(len(rows)))))
    far = np.einsum("kji,lj->lki", C_oc, ray)
    near = np.einsum("kji,lkj->lki", C_oc, s.a[rows][:, None] - p_c)
    z, seen = s.z[rows], s.seen[rows][:, :, None]
    by_rho, rest = ((z * y[:, :, 2:] - y[:, :, :2]) * seen for y in (near, far))
    power = np.sum(by_rho**2, axis=(1, 2))
    rho = -np.sum(by_rho * rest, axis=(1, 2)) / np.maximum(power, MIN_PARALLAX**2)
    is_known = (power > MIN_PARALLAX**2) & (rho > MIN_INVERSE_DEPTH)
    within = np.clip(rho, MIN_INVERSE_DEPTH, MAX_INVERSE_DEPTH)
    return np.where(is_known, within, DEFAULT_INVERSE_DEPTH)
