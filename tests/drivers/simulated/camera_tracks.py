"""A simulated camera: tracks of features along a known path, for recordings that have none.

At any time ``features`` points stand within ``depths`` of the view, as in the reference recordings:
one is drawn again, anywhere in the image, when another leaves the view or reaches the end of its life. Image
points have white noise; some are displaced, as by a wrong match.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import Trajectory

NEAREST = 0.2  # m, in front of which nothing is seen
ROUNDS = 5  # in which the row of a point is found, which says when, which says the row
Poses = Callable[[FloatArray], tuple[FloatArray, FloatArray]]  # times (n,) to C_nc (n, 3, 3) and places (n, 3)


@dataclass(frozen=True, slots=True)
class View:
    """What the camera sees: image size [px], features at a time, their depths [m] when first seen, rate [Hz].

    ``longest`` [s] is the longest life of a track, lives being spread evenly up to it; ``outliers`` is the share
    of image points that lie up to ``astray`` [px] off.
    """

    width: int = 752
    height: int = 480
    features: int = 120
    depths: tuple[float, float] = (2.0, 8.0)
    rate: float = 10.0
    longest: float = 4.0
    outliers: float = 0.02
    astray: float = 50.0


def simulate_tracks(path: Trajectory, camera: PinholeCamera, view: View, seed: int) -> FeatureTracks:
    """Return the tracks that ``camera`` would leave along ``path`` (IMU in n); equal seeds give equal tracks."""
    rng = np.random.default_rng(seed)
    late = abs(camera.row_time) * view.height
    t = np.arange(path.t[0] + late, path.t[-1] - late, 1 / view.rate)
    turned, gone = RotationSpline(path.t, Rotation.from_quat(path.q)), CubicSpline(path.t, path.p)

    def at(times: FloatArray) -> tuple[FloatArray, FloatArray]:
        C_nb = turned(times).as_matrix()
        return C_nb @ camera.C_bc, gone(times) + C_nb @ camera.t_bc

    scene = _Scene(camera, view, rng, at)
    rows = [scene.seen(float(now)) for now in t]
    feature, uv = (np.concatenate(parts) for parts in zip(*rows, strict=True))
    return FeatureTracks(np.repeat(t, [len(ids) for ids, _ in rows]), feature, uv)


class _Scene:
    """The features that stand in the view now."""

    def __init__(self, camera: PinholeCamera, view: View, rng: np.random.Generator, at: Poses) -> None:
        self.camera, self.view, self.rng, self.at = camera, view, rng, at
        self.p_n = np.zeros((0, 3))
        self.feature = np.zeros(0, np.int64)
        self.end = np.zeros(0)
        self.next = 0

    def seen(self, t: float) -> tuple[IntArray, FloatArray]:
        """Return features and noisy image points of one frame, whose middle row is taken at ``t`` [s]."""
        uv, inside = self._projected(t)
        keep = inside & (self.end > t)
        self.p_n, self.feature, self.end = self.p_n[keep], self.feature[keep], self.end[keep]
        uv = np.vstack((uv[keep], self._new(t)))
        noisy = uv + self.rng.normal(0, self.camera.std, uv.shape)
        wrong = self.rng.random(len(uv)) < self.view.outliers
        noisy[wrong] += self.rng.uniform(-self.view.astray, self.view.astray, (int(wrong.sum()), 2))
        return self.feature.copy(), noisy

    def _projected(self, t: float) -> tuple[FloatArray, np.ndarray]:
        """Return where the features stand, each in the row that is taken while it stands there."""
        when = np.full(len(self.p_n), t)
        for _ in range(ROUNDS if self.camera.row_time and len(when) else 1):
            C_nc, p_c = self.at(when)
            y = np.einsum("nji,nj->ni", C_nc, self.p_n - p_c)
            uv = self.camera.pixels(y[:, :2] / np.maximum(y[:, 2:], NEAREST))
            row = np.clip(uv[:, 1], 0, self.view.height)
            when = t + self.camera.row_time * (row - self.camera.cy)
        size = [self.view.width, self.view.height]
        return uv, (y[:, 2] > NEAREST) & (uv >= 0).all(axis=1) & (uv < size).all(axis=1)

    def _new(self, t: float) -> FloatArray:
        """Fill the view up and return where the new features stand in the image."""
        n, rng, view = self.view.features - len(self.feature), self.rng, self.view
        uv = rng.uniform(0, [view.width, view.height], (n, 2))
        y = np.column_stack((self.camera.rays(uv), np.ones(n))) * rng.uniform(*view.depths, n)[:, None]
        C_nc, p_c = self.at(t + self.camera.row_time * (uv[:, 1] - self.camera.cy))
        self.p_n = np.vstack((self.p_n, p_c + np.einsum("nij,nj->ni", C_nc, y)))
        self.feature = np.r_[self.feature, self.next + np.arange(n)]
        self.end = np.r_[self.end, t + rng.uniform(0, view.longest, n)]
        self.next += n
        return uv
