"""Image patches held to what they looked like where they were first seen, however scaled and sheared since.

From image to image errors add up, and a patch that has half on one thing and half on what stands behind it
slides along the edge between them: along the camera's way, so that no epipolar line shows it. Here each patch is
fitted to its *anchor*, how it looked at first, by an affine warp with brightness and contrast free (Shi, Tomasi
1994; inverse compositional, all patches at once: Baker, Matthews 2004). What no longer looks like its anchor is no
longer it, nor is a patch whose halves, each by itself, would go different ways: one of them stands elsewhere.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import BoolArray
from procedures.optional_libraries import opencv

Floats = NDArray[np.float32]
PATCH_HALF_PX = 6  # px: patches of 13; larger ones stand on edges more often, smaller ones drift
WEIGHT_SIGMA = 1 / 1.5  # of PATCH_HALF_PX: 1 sigma of what pixels weigh about the middle
MAX_ITERATIONS = 5
MAX_STRAIN, MAX_MOVE_PX = 0.3, 2.0  # of an affine warp, and px, in a round at most
GREY_NOISE = 3.0  # grey: warps that change a patch less than this are not followed
USUAL_WARP = np.array([0.5, 0.5, 0.5, 0.5, 5.0, 5.0], np.float32)  # warp and px, by which patches move
MIN_CONTRAST = 1.0  # grey: a patch of less contrast counts as of this
EDGE_REGULARISATION = 0.05  # of a half's gradients, against moves along its only edge
IDENTITY = np.eye(2, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class FittedPatches:
    """Where patches stand, ``uv`` (n, 2) [px], and their warps ``A`` (n, 2, 2), anchor to image.

    ``alike`` (n,) is the correlation with their anchors, ``apart`` (n,) [px] how far their halves would part.
    """

    uv: Floats
    A: Floats
    alike: Floats
    apart: Floats

    @property
    def stretch(self) -> Floats:
        """By how much a length in the anchor has grown or shrunk at most (n,), 1 where it has not."""
        sizes = np.linalg.svd(self.A, compute_uv=False)
        stretch: Floats = np.maximum(sizes[:, 0], 1 / np.maximum(sizes[:, 1], 1e-3))
        return stretch


class AnchoredPatches:
    """Anchors in rows: contrast ``_T`` (n, m), its gradients ``_G`` (n, 2, m), and what makes a step (n, 6, m)."""

    def __init__(self) -> None:
        self._cv: Any = opencv()
        line = np.arange(-PATCH_HALF_PX, PATCH_HALF_PX + 1, dtype=np.float32)
        self._d = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        weight = np.exp(-np.sum((self._d / (WEIGHT_SIGMA * PATCH_HALF_PX)) ** 2, axis=1) / 2)
        self._w = (weight / weight.sum()).astype(np.float32)
        x, y = self._d.T
        self._halves = tuple((self._w * which).astype(np.float32) for which in (x < 0, x > 0, y < 0, y > 0))
        m = len(self._d)
        self._A = np.zeros((0, 2, 2), np.float32)
        self._T, self._G = np.zeros((0, m), np.float32), np.zeros((0, 2, m), np.float32)
        self._step = np.zeros((0, 6, m), np.float32)

    def keep(self, which: BoolArray) -> None:
        """Keep the rows that ``which`` (n,) says are True, and forget all others."""
        self._A, self._T, self._G, self._step = (rows[which] for rows in (self._A, self._T, self._G, self._step))

    def add(self, image: Floats, uv: Floats) -> None:
        """Add anchors: the patches about points (n, 2) [px] of an image (h, w), grey."""
        whole = np.tile(IDENTITY, (len(uv), 1, 1)), *self._anchors(image, uv)
        rows = zip((self._A, self._T, self._G, self._step), whole, strict=True)
        self._A, self._T, self._G, self._step = (np.concatenate(pair) for pair in rows)

    def renew(self, image: Floats, uv: Floats, which: BoolArray) -> None:
        """Let rows ``which`` (n,) have a new anchor at ``uv`` (n, 2) [px], the points of all."""
        if which.any():
            self._A[which] = IDENTITY
            self._T[which], self._G[which], self._step[which] = self._anchors(image, uv[which])

    def fit(self, image: Floats, uv: Floats) -> FittedPatches:
        """Find all patches near points (n, 2) [px] of the next image; `fit` begins at the warps found before."""
        A, best = self._A, np.full(len(uv), np.inf, np.float32)
        found = uv.copy(), A.copy(), np.zeros_like(self._T)
        for _ in range(MAX_ITERATIONS):
            off = self._normal(self._seen(image, uv, A))[0] - self._T
            size = (off**2) @ self._w
            closer = size < best
            best[closer] = size[closer]
            for kept, now in zip(found, (uv, A, off), strict=True):
                kept[closer] = now[closer]
            due = (self._step @ off[:, :, None])[:, :, 0]
            A = A @ np.linalg.inv(IDENTITY + np.clip(due[:, :4], -MAX_STRAIN, MAX_STRAIN).reshape(-1, 2, 2))
            uv = uv - (A @ np.clip(due[:, 4:, None], -MAX_MOVE_PX, MAX_MOVE_PX))[:, :, 0]
        self._A = found[1]
        alike: Floats = 1 - best / np.float32(2)
        return FittedPatches(*found[:2], alike, self._apart(found[2]))

    def _apart(self, off: Floats) -> Floats:
        moves = []
        for weight in self._halves:
            G = self._G * weight
            H, due = G @ np.swapaxes(self._G, 1, 2), G @ off[:, :, None]
            H += (EDGE_REGULARISATION * np.trace(H, axis1=1, axis2=2))[:, None, None] * IDENTITY
            moves.append(np.linalg.solve(H, due)[:, :, 0])
        left, right, upper, lower = moves
        apart: Floats = np.maximum(np.linalg.norm(left - right, axis=1), np.linalg.norm(upper - lower, axis=1))
        return apart

    def _anchors(self, image: Floats, uv: Floats) -> tuple[Floats, Floats, Floats]:
        seen = np.tile(IDENTITY, (len(uv), 1, 1))
        raw = self._seen(image, uv, seen)
        T, size = self._normal(raw)
        sides = ([self._seen(image, uv + side * e, seen) for side in (1, -1)] for e in IDENTITY)
        sloped = np.stack([after - before for after, before in sides], axis=1)
        G: Floats = (sloped / (2 * size[:, None, None])).astype(np.float32)
        x, y = self._d.T
        S = np.stack((G[:, 0] * x, G[:, 0] * y, G[:, 1] * x, G[:, 1] * y, G[:, 0], G[:, 1]), axis=1)
        S -= (S @ self._w)[:, :, None]  # what brightness does is no move
        S -= (S @ (T * self._w)[:, :, None]) * T[:, None]  # nor what contrast does
        H = (S * self._w) @ np.swapaxes(S, 1, 2)
        H[:, range(6), range(6)] += (GREY_NOISE / size[:, None] / USUAL_WARP) ** 2
        return T, G, np.linalg.solve(H, S * self._w).astype(np.float32)

    def _normal(self, grey: Floats) -> tuple[Floats, Floats]:
        """Return patches (n, m) of mean 0 and mean square 1, and the contrast (n,) that they had."""
        grey = grey - (grey @ self._w)[:, None]
        size: Floats = np.sqrt(np.maximum((grey**2) @ self._w, np.float32(MIN_CONTRAST**2)))
        return grey / size[:, None], size

    def _seen(self, image: Floats, uv: Floats, A: Floats) -> Floats:
        at = uv[:, None] + self._d @ np.swapaxes(A, 1, 2)
        seen: Floats = self._cv.remap(
            image, at.astype(np.float32), None, self._cv.INTER_LINEAR, borderMode=self._cv.BORDER_REPLICATE
        )
        return seen
