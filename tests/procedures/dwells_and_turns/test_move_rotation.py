"""The change of a move's rotation with K and b is the derivative of the rotation, however long a sample is."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.move_rotation import MoveSamples, integrate_moves, move_rotations, padded_moves
from procedures.frames import rotation_vector

K = np.array([[36000.0, 30.0, -20.0], [-10.0, 35500.0, 15.0], [25.0, -40.0, 36400.0]])  # output/deg
B = np.array([5.0, -3.0, 2.0])  # output/s
STEPS = np.array([10.0] * 9 + [1.0] * 3)  # output/deg, output/s


def half_turn(axis: FloatArray, hz: float, seconds: float = 4.0) -> MoveSamples:
    """Half a turn about ``axis`` (3,), smooth, all within the middle half of the time."""
    u = np.clip((np.linspace(0.0, 1.0, round(seconds * hz) + 1) - 0.25) / 0.5, 0.0, 1.0)
    rates = 180.0 * np.diff(u**3 * (10 - 15 * u + 6 * u * u))[:, None] * hz * axis / np.linalg.norm(axis)
    return padded_moves([rates @ K.T + B], [1 / hz])


def derivative(samples: MoveSamples, change: FloatArray) -> FloatArray:
    """The rotation vector (3,) [rad] by which a small ``change`` (12,) of K and b turns the end of the move."""
    ends = [
        move_rotations(samples, K + way * change[:9].reshape(3, 3), B + way * change[9:])[0] for way in (0.5, -0.5)
    ]
    turned: FloatArray = -rotation_vector(ends[0] @ ends[1].T)
    return turned


@pytest.mark.parametrize(("hz", "within"), [(20.0, 2e-3), (50.0, 2e-4)])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.6, 0.8), (0.5, -0.7, 0.5)])
def test_the_change_of_a_rotation_is_its_derivative(
    axis: tuple[float, float, float], hz: float, within: float
) -> None:
    """Half a sample's turn beside it, 0.05 at 20 Hz, and what nothing shows would seem to be known."""
    samples = half_turn(np.array(axis), hz)
    found = integrate_moves(samples, K, B)
    assert Rotation.from_matrix(found.rotation[0] @ move_rotations(samples, K, B)[0].T).magnitude() < 1e-12
    expected = np.array([derivative(samples, step) / step.max() for step in np.diag(STEPS)]).T
    off, size = (np.linalg.norm(each, axis=0) for each in (found.sensitivity[0] - expected, expected))
    assert off[:9].max() < within * size[:9].max()
    assert off[9:].max() < within * size[9:].max()
