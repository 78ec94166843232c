"""A gap of the IMU is found, told what it costs, and bridged with a sigma that is as wide."""

from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.alignment.alignment_attempts import align_when_possible
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.imu.imu_gaps import imu_gaps
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from tests.procedures.fusion.motions import EARTH, GRAVITY, NOISE, Eight
from tests.procedures.fusion.seen import SITE

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
