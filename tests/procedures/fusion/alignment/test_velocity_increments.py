"""Velocities of fixes and the IMU's increments at them, by hand: a grid of four intervals."""

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.frames import skew
from procedures.fusion.alignment.velocity_increments import FixVelocities, MeanVelocities, observed_velocities
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.imu.inertial_increments import ImuGrid, InertialIncrements

T = np.array([10.0, 10.5, 11.5, 12.0])
IMU_T = np.arange(9.8, 12.3, 0.1)
IMU = ImuSeries(IMU_T, np.outer(IMU_T, [1.0, 2.0, 3.0]), np.zeros((len(IMU_T), 3)))


def fixes(t: np.ndarray = T, v: float = np.nan) -> GnssFixes:
    n = len(t)
    p = np.stack((t**2, 2 * t, np.zeros(n)), axis=1)
    return GnssFixes(
        t, p, np.full((n, 3), v), np.full(n, np.nan), 0.1 * np.arange(1.0, n + 1), 0.01 * np.arange(1.0, n + 1)
    )


def test_positions_alone_say_the_mean_velocity_between_them() -> None:
    found = observed_velocities(IMU, fixes())
    assert isinstance(found, MeanVelocities)
    np.testing.assert_allclose(found.v[:, 0], [20.5, 22.0, 23.5])  # the mean of 2 t
    np.testing.assert_allclose(found.v[:, 1], 2.0)
    np.testing.assert_allclose(found.elapsed, [0.25, 1.0, 1.75])
    s, dt = np.square([0.1, 0.2, 0.3, 0.4]), np.array([0.5, 1.0, 0.5])
    noise = np.diag((s[1:] + s[:-1]) / dt**2)
    noise[0, 1] = noise[1, 0] = -s[1] / (dt[0] * dt[1])  # they share a fix
    noise[1, 2] = noise[2, 1] = -s[2] / (dt[1] * dt[2])
    np.testing.assert_allclose(found.noise, noise)


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
