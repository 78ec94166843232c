"""Patches are found again as they were first seen; what is torn or no longer alike is said to be."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from procedures.fusion.vision.anchored_patches import AnchoredPatches, FittedPatches
from tests.procedures.fusion.rendered import texture

AT = np.stack(np.meshgrid(np.arange(60.0, 240.0, 30.0), np.arange(60.0, 240.0, 30.0)), axis=-1).reshape(-1, 2)
MIDDLE = np.array([150.0, 150.0])
Places = Callable[[np.ndarray], np.ndarray]


@cache
def wall() -> np.ndarray:
    return texture(1).astype(np.float32)


def image(back: Places, size: int = 300) -> np.ndarray:
    """Return the wall as seen where a pixel (u, v) shows the wall's point ``back`` of it."""
    v, u = np.mgrid[:size, :size].astype(float)
    at = back(np.stack((u, v), axis=-1)) + 200.0
    return map_coordinates(wall(), [at[..., 1], at[..., 0]], order=3).astype(np.float32)


def fitted(second: np.ndarray, guess: np.ndarray) -> FittedPatches:
    pytest.importorskip("cv2", reason="opencv is not installed")
    patches = AnchoredPatches()
    patches.add(image(lambda uv: uv), AT.astype(np.float32))
    return patches.fit(second, guess.astype(np.float32))


def test_a_patch_is_found_however_it_is_warped_and_lit() -> None:
    A = np.array([[1.1, 0.06], [-0.04, 0.94]])
    warped = image(lambda uv: (uv - MIDDLE) @ np.linalg.inv(A).T + MIDDLE)
    true = (AT - MIDDLE) @ A.T + MIDDLE
    found = fitted(0.7 * warped + 40.0, true + 0.7)
    off = np.linalg.norm(found.uv - true, axis=1)
    assert np.median(off) < 0.03
    assert np.quantile(off, 0.9) < 0.1
    assert np.abs(np.median(found.A, axis=0) - A).max() < 0.01
    assert np.median(found.alike) > 0.99
    assert np.quantile(found.apart, 0.9) < 0.1
    sizes = np.linalg.svd(A)[1]
    assert np.median(found.stretch) == pytest.approx(max(sizes[0], 1 / sizes[1]), rel=0.02)


def test_halves_that_go_apart_are_torn() -> None:
    """As at the edge of a near thing: what is right of each patch's middle goes 4 px on, the left does not."""
    right = image(lambda uv: uv - np.stack((4.0 * ((uv[..., 0] % 30.0) < 15.0), 0 * uv[..., 0]), axis=-1))
    found = fitted(right, AT)
    assert np.mean((found.apart > 0.3) | (found.alike < 0.9)) > 0.6  # a stretch explains the others: they drift
    assert np.mean(found.apart > 0.3) > 0.4
    assert np.quantile(fitted(image(lambda uv: uv), AT).apart, 0.9) < 0.05
