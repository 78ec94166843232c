"""What a camera saw: image points of features followed from frame to frame, and the camera that saw them.

``c`` is the camera: z along the view, x right, y down. Image points carry no distortion.

`derotated` brings the rows of a rolling shutter to the moment of their frame: what is seen in a row taken late by
d was seen by a camera that had turned by ``w d``. How far it moved meanwhile the window estimates
(`inner.landmarks`).
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray, interpolated
from procedures.frames import rotation
from procedures.fusion.fusion_records import ImuSeries


@dataclass(frozen=True, slots=True, eq=False)
class PinholeCamera:
    """Pinhole intrinsics [px], 1 sigma of an image point ``std`` [px], and where it sits on the IMU.

    ``C_bc`` (3, 3) takes camera to IMU axes, ``t_bc`` (3,) [m] is the camera in the IMU's axes. Each row is taken
    ``row_time`` [s] later than the one above it, the stamp being that of row ``cy``; 0: all at once.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    std: float
    C_bc: FloatArray
    t_bc: FloatArray
    row_time: float = 0.0

    @property
    def ray_time(self) -> float:
        """How much later [s] what stands lower by 1 on the plane at depth 1 is taken."""
        return self.row_time * self.fy

    def rays(self, uv: FloatArray) -> FloatArray:
        """Return image points ``uv`` (n, 2) [px] on the plane at depth 1."""
        return (uv - [self.cx, self.cy]) / [self.fx, self.fy]

    def pixels(self, rays: FloatArray) -> FloatArray:
        """Return points ``rays`` (n, 2) of the plane at depth 1 as image points [px]."""
        return rays * [self.fx, self.fy] + [self.cx, self.cy]


@dataclass(frozen=True, slots=True, eq=False)
class FeatureTracks:
    """One row an observation: ``t`` (m,) [s] not falling, ``feature`` (m,), ``uv`` (m, 2) [px].

    Rows of one time are one frame; a feature stands in it once and keeps its number from frame to frame.
    """

    t: FloatArray
    feature: IntArray
    uv: FloatArray

    def shifted(self, offset: float) -> "FeatureTracks":
        """Return the tracks with ``offset`` [s] added to their time stamps."""
        return FeatureTracks(self.t + offset, self.feature, self.uv)

    def frames(self) -> tuple[FloatArray, IntArray]:
        """Return the times (n,) of the frames, and where their rows begin (n + 1,)."""
        first = np.flatnonzero(np.r_[True, np.diff(self.t) > 0]) if len(self.t) else np.zeros(0, np.int64)
        return self.t[first], np.r_[first, len(self.t)].astype(np.int64)


MIN_FRAME_SPACING_S = 0.09  # s between frames that are used
PAIR_SPACING_S = 0.3  # s from a frame to its partner: parallax separates rotation from translation
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
    kept = list[int]()
    for i, t in enumerate(times):
        if not kept or t - times[kept[-1]] >= MIN_FRAME_SPACING_S:
            kept.append(i)
    rows = [slice(int(begin[i]), int(begin[i + 1])) for i in kept]
    found = [pair for k in range(len(kept)) if (pair := _partner(tracks.feature, times[kept], rows, k))]
    size = max((len(a) for _, _, a, _ in found), default=0)
    y0, y1 = np.ones((2, len(found), size, 3))
    there, rays = np.zeros((len(found), size)), camera.rays(tracks.uv)
    for k, (_, _, a, b) in enumerate(found):
        y0[k, : len(a), :2], y1[k, : len(b), :2], there[k, : len(a)] = rays[a], rays[b], 1.0
    t0, t1 = (np.array([times[kept[pair[i]]] for pair in found]) for i in (0, 1))
    return FramePairs(t0, t1, y0, y1, there)


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


SMOOTHED = 5  # samples whose mean is a rate: one alone is vibration


def derotated(tracks: FeatureTracks, imu: ImuSeries, camera: PinholeCamera) -> FeatureTracks:
    """Return the tracks as a camera had them that takes all rows at once; the same where this one does."""
    if not camera.row_time or not len(tracks.t):
        return tracks
    kernel = np.ones(SMOOTHED)
    count = np.convolve(np.ones(len(imu.t)), kernel, "same")  # fewer at the ends
    omega = np.stack([np.convolve(each, kernel, "same") / count for each in imu.omega_b.T], axis=1)
    rays = camera.rays(tracks.uv)
    rate_c = interpolated(tracks.t, imu.t, omega) @ camera.C_bc
    back = rotation(rate_c * (camera.ray_time * rays[:, 1:]))
    there = np.einsum("nij,nj->ni", back, np.column_stack((rays, np.ones(len(rays)))))
    return FeatureTracks(tracks.t, tracks.feature, camera.pixels(there[:, :2] / there[:, 2:]))
