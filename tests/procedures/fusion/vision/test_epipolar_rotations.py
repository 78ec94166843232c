"""How well turns fit what a camera saw: nought at the truth, and the slope of the cost beside it."""

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.vision.epipolar_rotations import EpipolarRotations
from procedures.fusion.vision.frame_pairs import FramePairs

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
