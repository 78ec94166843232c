"""Cameras from tracks alone: a planted way comes back up to scale, and with noise no other fits better."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.inner.landmarks import Landmarks
from procedures.fusion.vision.two_view import CameraStructure, structure

T = np.linspace(10.0, 12.5, 6)  # s
SCALE = np.array([400.0, 380.0])  # focal length over sigma
N = 150
POINTS = np.column_stack(
    (np.random.default_rng(1).uniform(-2, 2, (N, 2)), np.random.default_rng(2).uniform(2, 10, N))
)
WAY = np.array([[0, 0, 0], [0.2, 0.1, 0], [0.3, 0.2, 0.1], [0.5, 0.2, 0.1], [0.6, 0.1, 0], [0.8, 0.0, 0.1]])
TURNS = Rotation.from_rotvec(np.linspace([0, 0, 0], [0.05, -0.1, 0.08], 6) ** 2 * 3)


def rays(way: FloatArray = WAY, turns: Rotation = TURNS, points: FloatArray = POINTS) -> FloatArray:
    """Return where points (n, 3) are seen from a way (k, 3): (k, n, 2) on the plane at depth 1."""
    y = np.stack([turn.inv().apply(points - p) for turn, p in zip(turns, way, strict=True)])
    found: FloatArray = y[..., :2] / y[..., 2:]
    return found


def found_in(z: FloatArray, seed: int = 0) -> CameraStructure | str:
    """Return what is made of sights (k, n, 2)."""
    marks = Landmarks()
    for each in z:
        marks.add_frame(np.arange(z.shape[1]), each)
    return structure(marks, T, SCALE, np.random.default_rng(seed))


def in_units_of_the_last(p: FloatArray) -> FloatArray:
    scaled: FloatArray = p / np.linalg.norm(p[-1])
    return scaled


def test_a_way_without_noise_comes_back_up_to_scale() -> None:
    found = found_in(rays())
    assert isinstance(found, CameraStructure)
    np.testing.assert_allclose(found.C_0c, TURNS.as_matrix(), atol=1e-5)
    np.testing.assert_allclose(in_units_of_the_last(found.p_0), in_units_of_the_last(WAY), atol=1e-4)
    assert found.misfit < 1e-3


def placed(way: FloatArray, turns: Rotation, z: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the points (n, 3) that fit sights best by weighted least squares, and what is left (k, n, 2)."""
    X = POINTS * np.linalg.norm(way[-1]) / np.linalg.norm(WAY[-1])

    def left(X: FloatArray) -> FloatArray:
        found: FloatArray = (rays(way, turns, X) - z) * SCALE * weight[..., None]
        return found

    for _ in range(6):
        slopes = np.stack([(left(X + 1e-6 * e) - left(X - 1e-6 * e)) / 2e-6 for e in np.eye(3)], axis=-1)
        H, g = np.einsum("knia,knib->nab", slopes, slopes), np.einsum("knia,kni->na", slopes, left(X))
        X = X - np.linalg.solve(H, g[..., None])[..., 0]
    return X, left(X)


@pytest.mark.proof
@pytest.mark.parametrize("seed", [0, 1])
def test_with_noise_no_other_way_fits_better_by_hubers_loss(seed: int) -> None:
    z = rays() + np.random.default_rng(seed).normal(0, 0.9, (6, N, 2)) / SCALE
    found = found_in(z, seed)
    assert isinstance(found, CameraStructure)

    def left(x: FloatArray, weight: FloatArray) -> FloatArray:
        way, turns = found.p_0.copy(), Rotation.from_matrix(found.C_0c)
        way[1:] += x[:15].reshape(5, 3)
        return placed(
            way, turns * Rotation.from_rotvec(np.vstack((np.zeros(3), x[15:].reshape(5, 3)))), z, weight
        )[1]

    here, weight = np.zeros(30), np.ones((6, N))
    for _ in range(8):  # Huber's loss beyond two sigma, by weights
        size = np.linalg.norm(left(here, weight), axis=-1) / weight
        weight = np.sqrt(2 / np.maximum(size, 2))
    assert size.max() < 4  # none was left out
    r = left(here, weight).ravel()
    J = np.stack([(left(e, weight).ravel() - left(-e, weight).ravel()) / 2e-5 for e in 1e-5 * np.eye(30)], axis=1)
    J = np.delete(J, 12, axis=1)  # the last frame's x is the unit
    step, sigma = np.linalg.lstsq(J, r, rcond=None)[0], np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    assert np.abs(step / sigma).max() < 0.02
    freedom = 2 * 6 * N - 3 * N - 6 * 6
    assert found.misfit == pytest.approx(np.sum(size**2) / freedom, rel=1e-3)


def of_share(share: float, turns: Rotation = TURNS) -> tuple[CameraStructure | str, float]:
    """Return what is made of a share of the way, and the median parallax between its ends in sigmas by hand."""
    z = rays(share * WAY, turns)
    ahead = turns[-1].apply(np.column_stack((z[-1], np.ones(N))))
    moved = np.linalg.norm(ahead[:, :2] / ahead[:, 2:] - z[0], axis=1)
    return found_in(z), float(np.median(moved) * SCALE.mean())


def test_a_camera_that_only_turned_has_not_moved() -> None:
    still, _ = of_share(0.0)
    assert str(still).startswith("the image moves by 0.0 sigmas more than by a turn, 4 are needed")
