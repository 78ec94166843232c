"""Features followed from image to image: corners, KLT, each held to its first sight, one motion for all (OpenCV).

The tracker (Lucas, Kanade; pyramids) says where a feature went, a fit to the patch that it was at first where it
is (`anchored_patches`): steps alone drift, by a quarter of a pixel in twelve images, and slide along the edges of
near things, a tenth of them by five pixels and more, always backwards. A feature goes on where it still looks as
it did, and where it moves as one camera's motion before standing things has it: an essential matrix by random
samples and their least median, over two steps, then a fixed limit. RANSAC with a limit of 1 px bends itself round
what moves by itself: of a patch that went 5 px a frame it let 95 % pass a step, this 16 % (tests' rendered.py).
Lost ones make room for new corners, apart from all others.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.fusion.vision.anchored_patches import AnchoredPatches
from procedures.fusion.vision.two_view import sampson_distance
from procedures.optional_libraries import opencv

Image = NDArray[np.uint8]
MIN_EPIPOLAR_POINTS = 12  # points of which an epipolar geometry is had
LMEDS_CONFIDENCE = 0.7  # of one sample without a wrong point, were nearly half wrong: a quarter then gives 99.8 %


@dataclass(frozen=True, slots=True)
class FeatureTrackerSettings:
    """How many, and what may be missed.

    ``features`` at a time, ``apart`` [px] at least. Lost is what is less ``alike`` its first sight (correlation),
    ``torn`` [px] between its halves, ``corrected`` [px] from where the tracker had it, or ``epipolar`` [px] from
    one motion; how it looks is taken anew when ``stretched`` by more than that. ``window`` [px] and ``levels`` are
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
