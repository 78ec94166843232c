"""How a gyro says that a body turned: a steady rate, straight slopes, and the bias by differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.imu.gyro_rotations import GyroRotations

T = np.array([0.0, 0.1, 0.25, 0.3, 0.5])
STEADY, BIAS = np.array([0.4, -0.7, 1.1]), np.array([0.02, -0.01, 0.03])


def steady() -> ImuSeries:
    return ImuSeries(T, np.tile(STEADY, (5, 1)), np.zeros((5, 3)))


@pytest.mark.parametrize(("t0", "t1"), [(0.0, 0.5), (0.12, 0.31), (0.31, 0.12), (0.05, 0.05), (-0.1, 0.7)])
def test_a_steady_rate_turns_by_its_angle_even_beyond_the_samples(t0: float, t1: float) -> None:
    found, _ = GyroRotations(steady(), BIAS).turned(np.array([t0]), np.array([t1]))
    expected = Rotation.from_rotvec((STEADY - BIAS) * (t1 - t0)).inv().as_matrix()
    np.testing.assert_allclose(found[0], expected, atol=1e-12)


def test_the_bias_turns_it_from_the_left_by_its_slope() -> None:
    rng, step = np.random.default_rng(1), 1e-5
    t = np.linspace(0.0, 1.0, 201)
    imu = ImuSeries(t, np.cumsum(rng.normal(0, 0.1, (201, 3)), axis=0), np.zeros((201, 3)))
    t0, t1 = np.array([0.1, 0.6]), np.array([0.83, 0.22])
    at, slope = GyroRotations(imu, BIAS).turned(t0, t1)
    for axis in range(3):
        off, _ = GyroRotations(imu, BIAS + step * np.eye(3)[axis]).turned(t0, t1)
        left = Rotation.from_matrix(off @ np.swapaxes(at, 1, 2)).as_rotvec() / step
        np.testing.assert_allclose(left, slope[:, :, axis], atol=2e-4)
