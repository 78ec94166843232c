"""Frames of a camera two by two: what both saw of the same features, as arrays of equal length."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera

MIN_FRAME_SPACING_S = 0.09  # s between frames that are used
PAIR_SPACING_S = 0.3  # s from a frame to its partner: parallax tells turning from moving, and tracks still live
MAX_PAIR_SPACING_S = 0.65  # s, of a camera with few frames
WANTED_SHARED_FEATURES = 40  # features that a pair should have; where it has not, the partner is a nearer frame
MIN_SHARED_FEATURES = 20  # features without which there is no pair
MAX_PAIR_FEATURES = 120  # features of a pair that are used


@dataclass(frozen=True, slots=True, eq=False)
class FramePairs:
    """``t0``, ``t1`` (p,) [s]; points ``y0``, ``y1`` (p, k, 3) at depth 1, of which those count that are ``there``
    (p, k): 1 or 0.
    """  # noqa: D205

    t0: FloatArray
    t1: FloatArray
    y0: FloatArray
    y1: FloatArray
    there: FloatArray

    def __len__(self) -> int:
        return len(self.t0)

    def part(self, which: slice | IntArray, most: int = MAX_PAIR_FEATURES) -> "FramePairs":
        """Return some of the pairs, and at most ``most`` points of each."""
        y0, y1, there = (each[which, :most] for each in (self.y0, self.y1, self.there))
        return FramePairs(self.t0[which], self.t1[which], y0, y1, there)


def frame_pairs(tracks: FeatureTracks, camera: PinholeCamera) -> FramePairs:
    """Return each frame with a later one that still shares enough features with it."""
    times, begin = tracks.frames()
    kept = _spaced(times)
    rows = [slice(int(begin[i]), int(begin[i + 1])) for i in kept]
    found = [pair for k in range(len(kept)) if (pair := _partner(tracks.feature, times[kept], rows, k))]
    size = max((len(a) for _, _, a, _ in found), default=0)
    y0, y1 = np.ones((2, len(found), size, 3))
    there, rays = np.zeros((len(found), size)), camera.rays(tracks.uv)
    for k, (_, _, a, b) in enumerate(found):
        y0[k, : len(a), :2], y1[k, : len(b), :2], there[k, : len(a)] = rays[a], rays[b], 1.0
    t0, t1 = (np.array([times[kept[pair[i]]] for pair in found]) for i in (0, 1))
    return FramePairs(t0, t1, y0, y1, there)


def _spaced(times: FloatArray) -> list[int]:
    kept = list[int]()
    for i, t in enumerate(times):
        if not kept or t - times[kept[-1]] >= MIN_FRAME_SPACING_S:
            kept.append(i)
    return kept


def _partner(
    feature: IntArray, times: FloatArray, rows: list[slice], k: int
) -> tuple[int, int, IntArray, IntArray] | None:
    """Return frame ``k``, the frame that is best for it, and the rows (n,) of what they share, in both."""
    last = int(np.searchsorted(times, times[k] + PAIR_SPACING_S + MIN_FRAME_SPACING_S / 2, "right")) - 1
    if last == k and k + 1 < len(times) and times[k + 1] - times[k] <= MAX_PAIR_SPACING_S:
        last = k + 1
    for other in range(last, k, -1):
        _, a, b = np.intersect1d(feature[rows[k]], feature[rows[other]], assume_unique=True, return_indices=True)
        if len(a) >= (WANTED_SHARED_FEATURES if other > k + 1 else MIN_SHARED_FEATURES):
            some = np.random.default_rng(k).permutation(len(a))[:MAX_PAIR_FEATURES]
            return k, other, a[some] + rows[k].start, b[some] + rows[other].start
    return None
