"""Alignment finds a planted attitude within its own sigma, at rest and in motion, and waits where it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray, interpolated
from procedures.frames import skew
from procedures.fusion.alignment_attempts import align_at_rest, align_when_possible, fixes_between
from procedures.fusion.alignment_in_motion import FixVelocities, MeanVelocities, MovingAligner
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries, Waiting
from procedures.fusion.preintegration import ImuGrid, InertialIncrements, grid, integrate
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.fusion.motions import ACCEL_BIAS, EARTH, GRAVITY, GYRO_BIAS, NOISE, Eight, fog

LEVER = np.array([0.5, 0.2, -0.3])


def aligner(lever: np.ndarray | None = None) -> MovingAligner:
    return MovingAligner(NOISE, GRAVITY, EARTH, np.zeros(3) if lever is None else lever)


def off(aligned: AlignmentState, flight: Eight) -> np.ndarray:
    """Return the error of an attitude as a rotation about n (3,) [rad]."""
    E = aligned.C_now @ flight.attitude(np.array(aligned.t)).as_matrix().T
    return np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]]) / 2


@pytest.mark.parametrize("seed", range(2))
def test_ten_seconds_of_motion_give_attitude_and_biases_within_their_sigma(seed: int) -> None:
    flight, rng = Eight(11.0), np.random.default_rng(seed)
    found = aligner().align(flight.imu(rng, EARTH), fixes_between(flight.fixes(rng), 0.0, 10.0))
    assert isinstance(found, AlignmentState)
    error = off(found, flight)
    assert np.abs(error[:2]).max() < 4 * found.tilt_std
    assert abs(error[2]) < 4 * found.yaw_std
    sigma = np.sqrt(np.diag(found.covariance)[6:12])
    bias = np.r_[found.gyro_bias - GYRO_BIAS, found.accel_bias - ACCEL_BIAS]
    assert np.all(np.abs(bias) < 4 * sigma)
    assert 0.6 < found.misfit < 1.4


@pytest.mark.parametrize("seed", range(2))
def test_a_lever_arm_that_is_not_known_is_found_within_its_sigma(seed: int) -> None:
    flight, rng = Eight(20.0), np.random.default_rng(seed)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng, LEVER)
    found = replace(aligner(), lever_std=1.0).align(imu, fixes)
    assert isinstance(found, AlignmentState)
    assert found.lever is not None
    assert np.abs(off(found, flight)).max() < 4 * found.yaw_std
    sigma = np.sqrt(np.diag(found.covariance)[12:15])
    assert np.all(np.abs(found.lever - LEVER) < 4 * sigma)
    assert sigma.max() < 0.2


def test_a_receiver_without_vertical_velocity_is_enough() -> None:
    flight, rng = Eight(20.0), np.random.default_rng(2)
    fixes = flight.fixes(rng)
    fixes.v_n[:, 2] = np.nan
    found = aligner().align(flight.imu(rng, EARTH), fixes)
    assert isinstance(found, AlignmentState)
    assert abs(off(found, flight)[2]) < 4 * found.yaw_std


def test_it_waits_while_nothing_moves_and_begins_when_it_does() -> None:
    flight, rng = Eight(20.0, still=6.0), np.random.default_rng(3)
    found = align_when_possible(aligner(), flight.imu(rng, EARTH), flight.fixes(rng))
    assert isinstance(found, AlignmentState)
    assert 6.0 < found.t < 20.0
    assert abs(off(found, flight)[2]) < 4 * found.yaw_std


@pytest.mark.parametrize("seed", range(2))
def test_what_cannot_be_observed_is_never_accepted(seed: int) -> None:
    still, rng = Eight(12.0, still=12.0), np.random.default_rng(seed)
    found = aligner().align(still.imu(rng, EARTH), still.fixes(rng))
    assert isinstance(found, Waiting)
    assert "change the velocity more" in found.why
    flight = Eight(11.0)
    wrong = replace(flight.fixes(rng), v_n=-Eight(11.0, still=1.0).v(flight.fixes(rng).t)[:, [1, 0, 2]])
    assert isinstance(refused := aligner().align(flight.imu(rng, EARTH), wrong), Waiting)
    assert "do not match" in refused.why


@pytest.mark.parametrize("seed", range(2))
def test_a_receiver_of_positions_alone_is_enough_however_far_apart_they_are(seed: int) -> None:
    flight, rng = Eight(40.0), np.random.default_rng(seed)
    fixes = flight.fixes(rng, LEVER).part(
        slice(0, None, 40)
    )  # every two seconds, in which it flies a quarter round
    fixes.v_n[:] = np.nan
    found = aligner(LEVER).align(flight.imu(rng, EARTH), fixes)
    assert isinstance(found, AlignmentState)
    error = off(found, flight)
    assert np.abs(error[:2]).max() < 4 * found.tilt_std
    assert abs(error[2]) < 4 * found.yaw_std
    assert np.all(np.abs(found.v_n - flight.v(fixes.t[0])) < 4 * np.sqrt(np.diag(found.covariance)[3:6]))


def test_a_fog_at_rest_finds_north_by_the_earths_rate() -> None:
    rng = np.random.default_rng(5)
    bias = rng.normal(size=3) * 0.05 * RAD_S_PER_DEG_H
    imu, C_nb, noise = fog(rng, 300.0, bias)
    found = align_at_rest(imu, noise, GRAVITY, EARTH)
    assert isinstance(found, AlignmentState)
    E = found.C_nb @ C_nb.T
    yaw = (E[1, 0] - E[0, 1]) / 2
    east_bias = (C_nb @ bias)[0]
    assert abs(yaw - east_bias / EARTH[1]) < 3 * noise.gyro / np.sqrt(300.0) / EARTH[1]
    assert np.degrees(found.yaw_std) == pytest.approx(0.33, abs=0.05)  # 0.05 deg/h over Omega cos(55 deg)
    assert np.arccos(E[2, 2]) < 4 * found.tilt_std


def test_a_bench_that_is_disturbed_or_a_gyro_that_is_too_poor_is_refused() -> None:
    rng = np.random.default_rng(6)
    imu, _, noise = fog(rng, 60.0, np.zeros(3))
    imu.f_b[300:310] += 0.5
    assert isinstance(disturbed := align_at_rest(imu, noise, GRAVITY, EARTH), Waiting)
    assert "still" in disturbed.why
    imu, _, noise = fog(rng, 60.0, np.zeros(3))
    assert isinstance(poor := align_at_rest(imu, replace(noise, gyro_bias=1e-3), GRAVITY, EARTH), Waiting)
    assert "better gyros" in poor.why


@pytest.mark.parametrize(("length", "is_torn"), [(0.05, False), (2.0, True)])
def test_what_lies_before_a_gap_is_used_unless_the_attitude_was_lost_in_it(length: float, is_torn: bool) -> None:
    flight, rng = Eight(30.0), np.random.default_rng(1)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng)
    whole = align_when_possible(aligner(), imu, fixes)
    assert isinstance(whole, AlignmentState)
    begin = whole.t - length - 0.3  # just before it would have been aligned
    kept = (imu.t < begin) | (imu.t > begin + length)
    cut = replace(imu, t=imu.t[kept], omega_b=imu.omega_b[kept], f_b=imu.f_b[kept])
    found = align_when_possible(aligner(), cut, fixes)
    assert isinstance(found, AlignmentState)
    if is_torn:
        assert found.t >= begin + length + 3.0
    else:
        assert found.t == pytest.approx(whole.t, abs=0.1)


def align_as_printed(imu: ImuSeries, fixes: GnssFixes, gravity: float, gyro_bias: FloatArray) -> FloatArray:
    """Return C_nb (3, 3) at the last fix by Han's eq. 3 as printed: GNSS velocity differentiated, for comparison.

    Han 2022 (III.B) takes roll and pitch from ``C a_i = G + a_l`` and yaw from the track. Without a camera both
    come from the same equation, carried to one body frame by the gyro and solved for all instants at once (Wahba's
    problem). Differencing turns white velocity noise into ``sqrt(2) std / dt`` of acceleration, and no bias is
    estimated. Every fix has a velocity and lies within the IMU's data.
    """
    g = grid(imu, fixes.t)
    turned = integrate(g, gyro_bias, np.zeros(3)).C[g.at]
    a_n = np.gradient(fixes.v_n, fixes.t, axis=0) + np.array([0.0, 0.0, gravity])
    f_b = interpolated(fixes.t, imu.t, imu.f_b)
    felt = np.einsum("nij,nj->ni", turned, f_b)
    U, _, Vt = np.linalg.svd(a_n.T @ felt)
    C: FloatArray = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt @ turned[-1]
    return C


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
