"""Images of two textured walls before a moving camera, and where each of their points is seen."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation

from procedures.fusion.vision.feature_tracker import Image

WIDTH, HEIGHT, FOCAL = 376, 240, 230.0
K = np.array([[FOCAL, 0.0, WIDTH / 2], [0.0, FOCAL, HEIGHT / 2], [0.0, 0.0, 1.0]])
PER_M = 60.0  # texture pixels
DEPTHS = (5.0, 2.5)  # m, of the walls
NEAR_FROM = 0.3  # m: the near wall's left edge


@lru_cache
def texture(seed: int, size: int = 900) -> Image:
    """Return a wall with blots of all sizes."""
    rng = np.random.default_rng(seed)
    layers = [gaussian_filter(rng.normal(size=(size, size)), blur) * blur for blur in (1.5, 3.0, 8.0)]
    total = sum(layers)
    return np.asarray(np.clip(127 + 45 * total / np.std(total), 0, 255), np.uint8)


@dataclass
class Scene:
    """A camera that goes right, forward and turns; a patch that goes its own way, where asked."""

    cv: Any
    patch: bool = False
    noise: float = 2.0

    def pose(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the camera's C_wc and place; the walls stand across z."""
        turn = Rotation.from_rotvec([0.02 * np.sin(3 * t), 0.05 * np.sin(2 * t), 0.1 * t])
        return turn.as_matrix(), np.array([0.6 * t, 0.1 * np.sin(4 * t), 0.3 * t])

    def onto_wall(self, t: float, depth: float) -> np.ndarray:
        """Return the homography from a wall's x, y [m] to the image."""
        C, p = self.pose(t)
        across = np.column_stack(([1.0, 0, 0], [0, 1.0, 0], np.array([0, 0, depth]) - p))
        return K @ C.T @ across

    def image(self, t: float) -> Image:
        """Return what the camera sees."""
        seen = np.zeros((HEIGHT, WIDTH), np.uint8)
        for depth, seed in zip(DEPTHS, (1, 2), strict=True):
            wall = texture(seed)
            mask = np.full(wall.shape, 255, np.uint8)
            half = wall.shape[0] / 2 / PER_M
            if depth == DEPTHS[1]:
                mask[:, : round((NEAR_FROM + half) * PER_M)] = 0
            H = self.onto_wall(t, depth) @ np.array([[1 / PER_M, 0, -half], [0, 1 / PER_M, -half], [0, 0, 1]])
            drawn, there = (self.cv.warpPerspective(each, H, (WIDTH, HEIGHT)) for each in (wall, mask))
            seen[there > 127] = drawn[there > 127]
        if self.patch:
            u, v = round(40 + 40 * t), round(60 + 35 * t)
            seen[v : v + 70, u : u + 70] = np.kron(
                np.random.default_rng(3).choice([20, 235], (7, 7)), np.ones((10, 10))
            )
        rng = np.random.default_rng(round(1000 * t))
        return np.asarray(np.clip(seen + rng.normal(0, self.noise, seen.shape), 0, 255), np.uint8)

    def on_patch(self, t: float, uv: np.ndarray, margin: float = 12.0) -> np.ndarray:
        """Return which points lie on the patch or within ``margin`` [px] of it."""
        inside = (uv > np.array([40 + 40 * t, 60 + 35 * t]) - margin) & (
            uv < np.array([110 + 40 * t, 130 + 35 * t]) + 12
        )
        return inside.all(axis=1) & self.patch

    def seen_again(self, t0: float, uv: np.ndarray, t: float) -> np.ndarray:
        """Return where points (n, 2) of the image at t0 are seen at t; nan near the near wall's edge."""
        moved = np.full(uv.shape, np.nan)
        near = self._wall(t0, uv, DEPTHS[1])
        for depth, which in (
            (DEPTHS[1], near[:, 0] > NEAR_FROM + 0.15),
            (DEPTHS[0], near[:, 0] < NEAR_FROM - 0.15),
        ):
            wall = np.column_stack((self._wall(t0, uv[which], depth), np.ones(which.sum())))
            y = wall @ self.onto_wall(t, depth).T
            moved[which] = y[:, :2] / y[:, 2:]
        return moved

    def _wall(self, t: float, uv: np.ndarray, depth: float) -> np.ndarray:
        y = np.column_stack((uv, np.ones(len(uv)))) @ np.linalg.inv(self.onto_wall(t, depth)).T
        return y[:, :2] / y[:, 2:]


def frames(scene: Scene, seconds: float = 1.2, step: float = 0.1) -> Iterator[tuple[float, Image]]:
    """Yield time and image."""
    for t in np.arange(0.0, seconds, step):
        yield float(t), scene.image(float(t))
