"""Features followed from image to image: corners, KLT, each held to its first sight, one motion for all (OpenCV).

The tracker (Lucas, Kanade; pyramids) says where a feature went; steps alone drift, and slide along the edges of
near things. `AnchoredPatches` therefore fits each patch to its *anchor*, how it looked at first, by an affine warp
with brightness and contrast free (Shi, Tomasi 1994; inverse compositional, all patches at once: Baker, Matthews
2004). A patch is lost when it no longer looks like its anchor, or when its halves, each by itself, would move
differently: one of them is at another distance. It is lost, too, where it does not move as one camera before
standing things has it: an essential matrix by random samples and their least median, over two steps, then a fixed
limit.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.fusion.vision.two_view import sampson_distance
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


Image = NDArray[np.uint8]
MIN_EPIPOLAR_POINTS = 12  # points of which an epipolar geometry is had
LMEDS_CONFIDENCE = 0.7  # of one sample without a wrong point, were nearly half wrong: a quarter then gives 99.8 %


@dataclass(frozen=True, slots=True)
class FeatureTrackerSettings:
    """How many, and what may be missed.

    ``features`` at a time, ``apart`` [px] at least. Lost is what is less ``alike`` its first sight (correlation),
    ``torn`` [px] between its halves, ``corrected`` [px] from where the tracker had it, or ``epipolar`` [px] from
    one motion; its look is taken again when ``stretched`` by more than that. ``window`` [px] and ``levels`` are
    the tracker's, ``quality`` a corner's against the best one.
    """

    features: int = 150
    apart: float = 20.0
    alike: float = 0.9
    torn: float = 0.3
    corrected: float = 3.0
    stretched: float = 2.0
    epipolar: float = 0.5
    window: int = 21
    levels: int = 3
    quality: float = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class LensModel:
    """Pinhole intrinsics [px] and the lens's distortion (k1, k2, p1, p2[, k3]) as OpenCV has them."""

    fx: float
    fy: float
    cx: float
    cy: float
    distortion: FloatArray

    @property
    def K(self) -> FloatArray:
        """The intrinsics as a matrix (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def straightened(self, uv: FloatArray) -> FloatArray:
        """Return image points ``uv`` (n, 2) [px] as the lens would have them without distortion."""
        if not len(uv) or not self.distortion.any():
            return uv
        straight = opencv().undistortPoints(uv[:, None].astype(np.float64), self.K, self.distortion, P=self.K)
        return np.asarray(straight[:, 0], np.float64)


class FeatureTracker:
    """What stands in the last image; each call is the next image (h, w), 8 bit grey."""

    def __init__(self, lens: LensModel, settings: FeatureTrackerSettings | None = None) -> None:
        self.lens, self.settings = lens, settings or FeatureTrackerSettings()
        self.rejected = 0
        self._cv: Any = opencv()
        self._last: Image | None = None
        self._patches = AnchoredPatches()
        self._feature = np.zeros(0, np.int64)
        self._uv = np.zeros((0, 2), np.float32)
        self._before = np.zeros((0, 2), np.float32)  # where they stood an image earlier, nan for new ones
        self._next = 0

    def follow(self, image: Image) -> tuple[IntArray, FloatArray]:
        """Return the features (n,) in the next image and where they stand (n, 2) [px]."""
        if self._last is not None and self._last.shape != image.shape:
            raise ValueError(f"an image of {image.shape}, expected {self._last.shape} as those before it")
        grey = image.astype(np.float32)
        if self._last is not None and len(self._uv):
            self._go_on(self._last, image, grey)
        self._add(image, grey)
        self._last = image
        return self._feature.copy(), self._uv.astype(np.float64)

    def _go_on(self, last: Image, image: Image, grey: NDArray[np.float32]) -> None:
        uv, found = self._tracked(last, image)
        self._keep(found)
        uv, fits, stretched = self._fitted(grey, uv[found])
        fits[fits] = self._one_motion(self._before[fits], uv[fits])
        self._keep(fits)
        self._before, self._uv = self._uv, uv[fits]
        self._patches.renew(grey, self._uv, stretched[fits])

    def _keep(self, which: BoolArray) -> None:
        self._patches.keep(which)
        self._feature, self._before, self._uv = self._feature[which], self._before[which], self._uv[which]

    def _tracked(self, last: Image, image: Image) -> tuple[NDArray[np.float32], BoolArray]:
        s = self.settings
        there, found, _ = self._cv.calcOpticalFlowPyrLK(
            last, image, self._uv[:, None], None, winSize=(s.window, s.window), maxLevel=s.levels
        )
        return there[:, 0], (found[:, 0] == 1) & _inside(there[:, 0], image)

    def _fitted(
        self, grey: NDArray[np.float32], uv: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], BoolArray, BoolArray]:
        """Return where the patches stand (n, 2), which are still the same, and which need a new anchor."""
        s, fitted = self.settings, self._patches.fit(grey, uv)
        near = np.linalg.norm(fitted.uv - uv, axis=1) < s.corrected
        fits = near & (fitted.alike > s.alike) & (fitted.apart < s.torn) & _inside(fitted.uv, grey)
        return fitted.uv, fits, fitted.stretch > s.stretched

    def _one_motion(self, before: NDArray[np.float32], after: NDArray[np.float32]) -> BoolArray:
        """Return which points move as one camera has it; those too new to say do, and all where they are few."""
        kept = np.ones(len(before), bool)
        known = np.flatnonzero(np.isfinite(before[:, 0]))
        if len(known) < MIN_EPIPOLAR_POINTS:
            return kept
        pair = [self.lens.straightened(each[known].astype(np.float64)) for each in (before, after)]
        self._cv.setRNGSeed(0)  # equal images give equal tracks
        E, _ = self._cv.findEssentialMat(*pair, self.lens.K, self._cv.LMEDS, LMEDS_CONFIDENCE)
        if E is None:
            return kept
        kept[known] = self._off(np.asarray(E[:3], np.float64), *pair) < self.settings.epipolar
        self.rejected += int(np.count_nonzero(~kept))
        return kept

    def _off(self, E: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
        """Return how far [px] points lie from what a motion says."""
        inverse = np.linalg.inv(self.lens.K)
        y0, y1 = (np.column_stack((uv, np.ones(len(uv)))) @ inverse.T for uv in (before, after))
        off: FloatArray = sampson_distance(E[None], y0, y1)[0] * np.sqrt(self.lens.fx * self.lens.fy)
        return off

    def _add(self, image: Image, grey: NDArray[np.float32]) -> None:
        s, missing = self.settings, self.settings.features - len(self._uv)
        if missing <= 0:
            return
        free = np.full(image.shape, 255, np.uint8)
        for u, v in self._uv:
            self._cv.circle(free, (round(float(u)), round(float(v))), round(s.apart), 0, -1)
        found = self._cv.goodFeaturesToTrack(image, missing, s.quality, s.apart, mask=free)
        if found is None:
            return
        new = found.reshape(-1, 2)
        self._patches.add(grey, new)
        self._uv = np.vstack((self._uv, new))
        self._before = np.vstack((self._before, np.full_like(new, np.nan)))
        self._feature = np.r_[self._feature, self._next + np.arange(len(new))]
        self._next += len(new)


def _inside(uv: NDArray[np.float32], image: NDArray[np.uint8] | NDArray[np.float32]) -> BoolArray:
    return np.asarray(((uv >= 0) & (uv <= np.array(image.shape[::-1]) - 1)).all(axis=1), bool)
