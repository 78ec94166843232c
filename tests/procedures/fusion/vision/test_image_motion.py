"""Motion between images: relative pose of two views, rotations by epipolar geometry, patches."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.feature_tracks import FramePairs
from procedures.fusion.vision.feature_tracker import AnchoredPatches, FittedPatches
from procedures.fusion.vision.two_view import EpipolarRotations, sampson_distance, two_view
from tests.procedures.fusion.rendered import texture

TURN, WAY = np.array([0.02, -0.05, 0.1]), np.array([0.6, -0.3, 0.2])


def seen(points: int, wrong: int = 0, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return where both cameras see the points (n, 2), the first ``wrong`` of them elsewhere in the second."""
    rng = np.random.default_rng(3)
    X = np.column_stack((rng.uniform(-3, 3, (points, 2)), rng.uniform(3, 12, points)))
    Y = (X - WAY) @ rotation(TURN)  # C_01 takes camera 1 to camera 0
    x0, x1 = X[:, :2] / X[:, 2:], Y[:, :2] / Y[:, 2:]
    x1 = x1 + noise * rng.standard_normal(x1.shape)
    x1[:wrong] += rng.uniform(0.1, 0.3, (wrong, 2)) * rng.choice([-1, 1], (wrong, 2))
    return x0, x1


@pytest.mark.parametrize(("wrong", "noise"), [(0, 0.0), (20, 0.0), (20, 1e-3)])
def test_turn_and_direction_are_found_among_wrong_points(wrong: int, noise: float) -> None:
    x0, x1 = seen(80, wrong, noise)
    found = two_view(x0, x1, 0.003, np.random.default_rng(1))
    assert found is not None
    allowed = 1e-7 if wrong == 0 else 0.01  # a wrong point may lie within the limit
    assert found.C_01 == pytest.approx(rotation(TURN), abs=allowed)
    assert found.p_0 == pytest.approx(WAY / np.linalg.norm(WAY), abs=3 * allowed)
    assert found.agree[wrong:].mean() > 0.8
    assert found.agree[:wrong].sum() <= 2  # along their own line wrong points are none


def test_too_few_points_say_nothing() -> None:
    assert two_view(*seen(19), 0.003, np.random.default_rng(1)) is None
    assert two_view(*seen(20), 0.003, np.random.default_rng(1)) is not None


def test_sampsons_distance_of_a_sideways_move_is_the_height_off_over_root_two() -> None:
    # moved along x: E = [t]x, epipolar lines are level; both points share the distance
    E = np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]])
    y0, y1 = np.array([[0.1, 0.2, 1.0]]), np.array([[-0.3, 0.25, 1.0]])
    assert sampson_distance(E, y0, y1)[0] == pytest.approx([0.05 / np.sqrt(2)])


# How well turns fit what a camera saw: zero at the truth, and the slope of the cost next to it


TURNS = Rotation.from_rotvec([[0.1, -0.2, 0.05], [-0.05, 0.1, 0.3]])
R = TURNS.as_matrix()
WAYS = np.array([[0.6, 0.3, 0.1], [-0.2, 0.5, 0.4]])
STD = np.array([1e-3, 1.5e-3])


def pairs(noise: float = 0.0, k: int = 60, seed: int = 1) -> FramePairs:
    """Return two pairs; of the second 20 points are there."""
    rng = np.random.default_rng(seed)
    X = rng.uniform([-2.0, -2.0, 3.0], [2.0, 2.0, 9.0], (2, k, 3))
    there = np.ones((2, k))
    there[1, 20:] = 0.0
    Y = np.einsum("pij,pkj->pki", R, X) + WAYS[:, None]
    y0, y1 = X / X[..., 2:], Y / Y[..., 2:]
    for y in (y0, y1):
        y[..., :2] += noise * STD * rng.normal(size=(2, k, 2))
    y0[1, 20:], y1[1, 20:] = 1.0, 1.0
    return FramePairs(np.zeros(2), np.ones(2), y0, y1, there)


def turned(by: FloatArray) -> FloatArray:
    return np.asarray((Rotation.from_rotvec(by) * TURNS).as_matrix())


def test_at_the_truth_there_is_no_slope_and_a_turn_is_found_back_by_a_step() -> None:
    given = pairs()
    assert np.abs(EpipolarRotations(given, STD).misfit(R).g).max() < 1e-3
    by = np.array([[1e-4, -2e-4, 1.5e-4], [-1e-4, 1e-4, 2e-4]])
    found = EpipolarRotations(given, STD).misfit(turned(by))
    step = np.linalg.solve(found.H, -found.g[..., None])[..., 0]
    np.testing.assert_allclose(step, -by, atol=4e-6)


def cost(given: FramePairs, R_10: FloatArray, t: FloatArray, loss: float) -> float:
    """Return half the cost of the first pair by Sampson's variance, from the essential matrix."""
    cross = np.array([[0, -t[2], t[1]], [t[2], 0, -t[0]], [-t[1], t[0], 0]])
    essential = cross @ R_10
    at1, at0 = given.y0[0] @ essential.T, given.y1[0] @ essential
    variance = (at1[:, :2] ** 2 + at0[:, :2] ** 2) @ STD**2
    e2 = np.einsum("ki,ki->k", given.y1[0], at1) ** 2 / variance
    return 0.5 * float(np.sum(e2 / (1 + e2 / loss**2)))


def test_the_gradient_is_that_of_the_cost_with_the_way_that_is_best() -> None:
    given, by = pairs(1.0), np.array([[4e-3, -2e-3, 3e-3], [0.0, 0.0, 0.0]])
    found = EpipolarRotations(given, STD, rounds=12).misfit(turned(by))

    def least(off: FloatArray) -> float:
        R_10 = turned(by + np.vstack((off, np.zeros(3))))[0]
        best = minimize(lambda t: cost(given, R_10, t / np.linalg.norm(t), 4.0), WAYS[0], tol=1e-12)
        return float(best.fun)

    step = 2e-4
    slope = [(least(step * axis) - least(-step * axis)) / (2 * step) for axis in np.eye(3)]
    np.testing.assert_allclose(found.g[0], slope, rtol=0.15, atol=0.05 * np.abs(slope).max())


# Patches that are followed from image to image


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
