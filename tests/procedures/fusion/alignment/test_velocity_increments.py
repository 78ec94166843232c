"""Velocities of fixes and the IMU's increments at them, by hand: a grid of four intervals."""

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.frames import skew
from procedures.fusion.alignment_in_motion import FixVelocities, MeanVelocities
from procedures.fusion.preintegration import ImuGrid, InertialIncrements

T = np.array([10.0, 10.5, 11.5, 12.0])


GRID = ImuGrid(np.array([0.02, 0.08, 0.04, 0.06]), np.zeros((4, 3)), np.zeros((4, 3)), np.array([0, 2, 4]))
RNG = np.random.default_rng(1)
MADE = InertialIncrements(
    Rotation.random(5, random_state=2).as_matrix(),
    RNG.normal(size=(5, 3)),
    RNG.normal(size=(5, 3, 3)),
    RNG.normal(size=(5, 3, 3)),
)


def test_at_fixes_increments_are_taken_as_they_are_and_the_arm_swings_by_the_rate() -> None:
    omega, bias = RNG.normal(size=(3, 3)), np.array([0.1, -0.2, 0.3])
    made = FixVelocities(T[:3], np.zeros((3, 3)), np.eye(3), omega).reach(GRID, MADE, bias)
    at = [0, 2, 4]
    for found, given in ((made.alpha, MADE.alpha), (made.by_gyro, MADE.by_gyro), (made.by_accel, MADE.by_accel)):
        np.testing.assert_array_equal(found, given[at])
    np.testing.assert_allclose(made.arm, [MADE.C[k] @ skew(w - bias) for k, w in zip(at, omega, strict=True)])
    a = MADE.alpha  # edges at 0, 0.02, 0.10, 0.14, 0.20; 0.03 s to either side, as far as there are any
    first = (a[1] + (a[2] - a[1]) / 8 - a[0]) / 0.03
    middle = (a[2] + 0.75 * (a[3] - a[2]) - (a[1] + 5 / 8 * (a[2] - a[1]))) / 0.06
    last = (a[4] - (a[3] + a[4]) / 2) / 0.03
    np.testing.assert_allclose(made.by_time, [first, middle, last])


def test_between_fixes_increments_are_means_over_time() -> None:
    t = np.array([5.0, 5.1, 5.2])
    made = MeanVelocities(t, np.zeros((2, 3)), np.eye(2)).reach(GRID, MADE, np.zeros(3))
    for found, v in ((made.alpha, MADE.alpha), (made.by_gyro, MADE.by_gyro), (made.by_accel, MADE.by_accel)):
        one = ((v[0] + v[1]) / 2 * 0.02 + (v[1] + v[2]) / 2 * 0.08) / 0.1
        two = ((v[2] + v[3]) / 2 * 0.04 + (v[3] + v[4]) / 2 * 0.06) / 0.1
        np.testing.assert_allclose(found, [one, two])
    np.testing.assert_allclose(made.arm, [(MADE.C[2] - MADE.C[0]) / 0.1, (MADE.C[4] - MADE.C[2]) / 0.1])
    np.testing.assert_allclose(
        made.by_time, [(MADE.alpha[2] - MADE.alpha[0]) / 0.1, (MADE.alpha[4] - MADE.alpha[2]) / 0.1]
    )
