"""Features followed from image to image: corners, KLT forward and back, one motion for all (OpenCV).

A feature goes on where the tracker, set back from where it led, returns to where it came from (Kalal, Mikolajczyk,
Matas 2010), and where it moves as one camera's motion before standing things has it: an essential matrix by random
samples and their least median, over two steps, then a fixed limit. RANSAC with a limit of 1 px bends itself round
what moves by itself: of a patch that went 5 px a frame it let 95 % pass a step, this 16 % (tests' rendered.py).
Lost ones make room for new corners, apart from all others.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.fusion.extra import opencv
from procedures.fusion.two_view import sampson_distance

Image = NDArray[np.uint8]
FEWEST = 12  # points of which an epipolar geometry is had
SURE = 0.999  # of one sample without a wrong point


@dataclass(frozen=True, slots=True)
class FollowerSettings:
    """How many, and what may be missed.

    ``features`` at a time, ``apart`` [px] at least; ``returned`` [px] after forward and back, ``epipolar`` [px] by
    one motion. ``window`` [px] and ``levels`` are the tracker's, ``quality`` a corner's against the best one.
    """

    features: int = 150
    apart: float = 20.0
    returned: float = 0.5
    epipolar: float = 0.75
    window: int = 21
    levels: int = 3
    quality: float = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
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
        """Return image points (n, 2) [px] as the lens would have them without distortion."""
        if not len(uv) or not self.distortion.any():
            return uv
        straight = opencv().undistortPoints(uv[:, None].astype(np.float64), self.K, self.distortion, P=self.K)
        return np.asarray(straight[:, 0], np.float64)


class FeatureFollower:
    """What stands in the last image; each call is the next image (h, w), 8 bit grey."""

    def __init__(self, lens: Lens, settings: FollowerSettings | None = None) -> None:
        self.lens, self.settings = lens, settings or FollowerSettings()
        self.rejected = 0
        self._cv: Any = opencv()
        self._last: Image | None = None
        self._feature = np.zeros(0, np.int64)
        self._uv = np.zeros((0, 2), np.float32)
        self._before = np.zeros((0, 2), np.float32)  # where they stood an image earlier, nan for new ones
        self._next = 0

    def follow(self, image: Image) -> tuple[IntArray, FloatArray]:
        """Return the features (n,) in the next image and where they stand (n, 2) [px]."""
        if self._last is not None and self._last.shape != image.shape:
            raise ValueError(f"an image of {image.shape}, expected {self._last.shape} as those before it")
        if self._last is not None and len(self._uv):
            uv, good = self._tracked(self._last, image)
            good[good] = self._one_motion(self._before[good], uv[good])
            self._feature, self._before, self._uv = self._feature[good], self._uv[good], uv[good]
        self._add(image)
        self._last = image
        return self._feature.copy(), self._uv.astype(np.float64)

    def _tracked(self, last: Image, image: Image) -> tuple[NDArray[np.float32], BoolArray]:
        there, found = self._klt(last, image, self._uv)
        back, returned = self._klt(image, last, there)
        off = np.linalg.norm(back - self._uv, axis=1)
        inside = (there >= 0).all(axis=1) & (there <= np.array(image.shape[::-1]) - 1).all(axis=1)
        return there, found & returned & inside & (off < self.settings.returned)

    def _klt(self, first: Image, second: Image, uv: NDArray[np.float32]) -> tuple[NDArray[np.float32], BoolArray]:
        s = self.settings
        there, found, _ = self._cv.calcOpticalFlowPyrLK(
            first, second, uv[:, None], None, winSize=(s.window, s.window), maxLevel=s.levels
        )
        return there[:, 0], found[:, 0] == 1

    def _one_motion(self, before: NDArray[np.float32], after: NDArray[np.float32]) -> BoolArray:
        """Return which points move as one camera has it; those too new to say do, and all where they are few."""
        kept = np.ones(len(before), bool)
        known = np.flatnonzero(np.isfinite(before[:, 0]))
        if len(known) < FEWEST:
            return kept
        pair = [self.lens.straightened(each[known].astype(np.float64)) for each in (before, after)]
        self._cv.setRNGSeed(0)  # equal images give equal tracks
        E, _ = self._cv.findEssentialMat(*pair, self.lens.K, self._cv.LMEDS, SURE)
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

    def _add(self, image: Image) -> None:
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
        self._uv = np.vstack((self._uv, new))
        self._before = np.vstack((self._before, np.full_like(new, np.nan)))
        self._feature = np.r_[self._feature, self._next + np.arange(len(new))]
        self._next += len(new)
