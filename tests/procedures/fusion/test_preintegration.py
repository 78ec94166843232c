"""GNSS velocity by heights and lever arm, rotations by gyroscopes, and gaps of the IMU."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.alignment_attempts import align_when_possible
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries
from procedures.fusion.gnss_velocity import (
    CLIMB_RATE_STD,
    CLIMB_SPAN_S,
    GnssMeasurements,
    LeverArm,
    measurements,
)
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.preintegration import GyroRotations, Preintegrated, imu_gaps
from tests.procedures.fusion.motions import EARTH, GRAVITY, NOISE, SITE, Eight

RISE, STD, RATE = 0.5, 0.3, 5.0  # m/s, m, Hz


def climbing(seconds: float = 60.0, seed: int = 0) -> GnssFixes:
    t = np.arange(0.0, seconds, 1 / RATE)
    p = np.zeros((len(t), 3))
    p[:, 2] = RISE * t + np.random.default_rng(seed).normal(0, STD, len(t))
    v, of_each = np.tile([3.0, 0.0, np.nan], (len(t), 1)), np.ones(len(t))
    return GnssFixes(t, p, v, np.full(len(t), np.nan), STD * of_each, 0.1 * of_each)


def reported(fixes: GnssFixes) -> GnssMeasurements:
    t = np.arange(-1.0, fixes.t[-1] + 1.0, 0.05)
    return measurements(fixes, ImuSeries(t, np.zeros((len(t), 3)), np.zeros((len(t), 3))))


def test_heights_say_how_fast_it_climbs_as_well_as_they_are_known() -> None:
    found = reported(climbing())
    early = found.t < CLIMB_SPAN_S / 2
    assert np.all(np.isinf(found.v_std[early, 2]))
    late = found.t >= CLIMB_SPAN_S
    off = found.v_n[late, 2] - RISE
    expected = np.sqrt(CLIMB_SPAN_S * RATE) * np.hypot(np.sqrt(2) * STD / CLIMB_SPAN_S, CLIMB_RATE_STD)
    assert np.allclose(found.v_std[late, 2], expected, rtol=0.05)
    weight = found.v_std[late, 2] ** -2
    assert abs((weight * off).sum() / weight.sum()) < 4 / np.sqrt(weight.sum())
    assert np.allclose(found.v_n[:, 0], 3.0)
    assert np.allclose(found.v_std[:, 0], 0.1)


def test_an_antenna_swings_where_the_body_points_at_the_fix_seen_from_the_keyframe() -> None:
    """A body turns steadily by 0.3 rad up to the keyframe; the fix fell a quarter of it after the beginning."""
    omega_b, dt, since = np.array([1.0, -2.0, 2.0]), 0.1, 0.025
    none, square = np.zeros(3), np.zeros((9, 9))
    part = Preintegrated(
        dt, rotation(omega_b * dt), none, none, none, none, square[:, :6], square, np.array([0.0, dt]),
        np.zeros((2, 3)), np.zeros((2, 3)),
    )  # fmt: skip
    one = np.ones((1, 3))
    fixes = GnssMeasurements(np.array([since]), 0 * one, one, 0 * one, one, omega_b[None])
    fix = fixes.at_end(0.0, part, np.eye(3), none, LeverArm(none))
    C_1f = rotation(omega_b * (since - dt))  # from b at the fix to b at the keyframe
    lever = np.array([0.3, 1.0, -0.5])
    assert fix.swing @ lever == pytest.approx(C_1f @ np.cross(omega_b, lever), abs=0.3**2 / 8 * 3.5)
    assert fix.age == pytest.approx(since - dt)


# Rotations from gyroscope samples


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


# Gaps of the IMU


LOST = (12.0, 13.0)  # s


def with_gap(imu: ImuSeries, first: float, last: float) -> ImuSeries:
    """Return an IMU without the samples of a span."""
    kept = (imu.t <= first) | (imu.t >= last)
    return ImuSeries(imu.t[kept], imu.omega_b[kept], imu.f_b[kept])


def test_a_gap_costs_what_a_line_over_it_misses() -> None:
    flight, rng = Eight(60.0), np.random.default_rng(1)
    whole = flight.imu(rng, EARTH)
    assert imu_gaps(whole) == ()
    missed = []
    for first in np.arange(2.0, 58.0, 1.7):
        (gap,) = imu_gaps(with_gap(whole, first, first + 1.0))
        inside = (whole.t >= gap.first) & (whole.t <= gap.last)
        line = (whole.f_b[inside][0] + whole.f_b[inside][-1]) / 2
        missed.append(((whole.f_b[inside].mean(axis=0) - line) ** 2).mean() / gap.force_std**2)
    assert gap.length == pytest.approx(1.0, abs=0.011)
    assert 0.5 < np.mean(missed) < 1.5  # some thirty gaps of three axes


@cache
def over_the_gap(seed: int) -> list[tuple[float, FloatArray, FloatArray]]:
    """Return time [s], error (3,) and covariance (3, 3) of the positions of one layer."""
    flight, rng = Eight(16.0), np.random.default_rng(seed)
    imu, fixes = with_gap(flight.imu(rng, EARTH), *LOST), flight.fixes(rng)
    fixes = fixes.part((fixes.t < LOST[0] - 0.2) | (fixes.t > LOST[1] + 0.2))
    aligned = align_when_possible(MovingAligner(NOISE, GRAVITY, EARTH, np.zeros(3)), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    tight = InertialWindow(WindowSettings(SITE, np.zeros(3), layers=1), imu, fixes, aligned)
    poses = ((each.t, each.p_o) for each in tight.poses())
    return [(t, p - flight.p(np.array(t)), tight.covariance_n[:3, :3].copy()) for t, p in poses]


@pytest.mark.proof
@pytest.mark.parametrize("seed", range(2))
def test_a_window_bridges_a_gap_within_its_own_sigma(seed: int) -> None:
    track = over_the_gap(seed)
    inside = [(e, covariance) for t, e, covariance in track if LOST[0] < t < LOST[1] + 0.2]
    assert inside
    assert all(e @ np.linalg.solve(covariance, e) < 16.3 for e, covariance in inside)  # 0.1 % of three axes
    assert np.linalg.norm(track[-1][1]) < 0.2


def test_an_alignment_looks_only_at_what_follows_a_gap_that_lost_the_attitude() -> None:
    flight, rng = Eight(30.0), np.random.default_rng(4)
    imu, fixes = with_gap(flight.imu(rng, EARTH), 3.0, 6.0), flight.fixes(rng)
    aligned = align_when_possible(MovingAligner(NOISE, GRAVITY, EARTH, np.zeros(3)), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    assert aligned.t0 >= 6.0
    error = aligned.C_now @ flight.attitude(np.array(aligned.t)).as_matrix().T
    assert abs(error[1, 0] - error[0, 1]) / 2 < 4 * aligned.yaw_std
