"""A camera moved by a known turn and a known way before points at many depths, a third of them wrong."""

import numpy as np
import pytest

from procedures.frames import rotation
from procedures.fusion.vision.two_view import sampson_distance, two_view

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
