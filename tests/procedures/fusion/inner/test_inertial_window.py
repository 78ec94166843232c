"""The inertial window follows a planted flight."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from procedures.fusion.alignment_attempts import align_at_rest, align_when_possible, between
from procedures.fusion.alignment_in_motion import MovingAligner
from procedures.fusion.fusion_records import AlignmentState, GnssFixes, ImuSeries
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.fusion.inner.window_state import ACCEL, GYRO
from procedures.fusion.inner.window_terms import Site
from procedures.fusion.pose_graph import PoseGraph
from procedures.units import RAD_S_PER_DEG_H
from tests.procedures.fusion.motions import ACCEL_BIAS, EARTH, GRAVITY, GYRO_BIAS, NOISE, SITE, Eight, fog

ZERO = np.zeros(3)
LEVER = np.array([0.5, 0.2, -0.3])


@cache
def aligned_flight(flight: Eight, seed: int) -> tuple[ImuSeries, GnssFixes, AlignmentState]:
    rng = np.random.default_rng(seed)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng)
    aligned = align_when_possible(MovingAligner(NOISE, GRAVITY, EARTH, ZERO), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    return imu, fixes, aligned


def window(flight: Eight, seed: int, layers: int) -> InertialWindow:
    imu, fixes, aligned = aligned_flight(flight, seed)
    return InertialWindow(WindowSettings(SITE, ZERO, layers), imu, fixes, aligned)


@pytest.fixture(scope="module")
def flight() -> Eight:
    return Eight(25.0)


@pytest.mark.proof
def test_one_layer_follows_within_its_own_sigma(flight: Eight) -> None:
    tight = window(flight, 1, layers=1)
    nees = []
    for pose in tight.poses():
        if pose.t > 8.0:
            e = pose.p_o - flight.p(np.array(pose.t))
            nees.append(e @ np.linalg.solve(tight.covariance_n[:3, :3], e) / 3)
    assert 0.3 < np.mean(nees) < 2.0  # some twenty independent errors
    sigma = np.sqrt(np.diag(tight.covariance(slice(tight.last + GYRO.start, tight.last + ACCEL.stop))))
    bias = np.r_[tight.state.bg[-1] - GYRO_BIAS, tight.state.ba[-1] - ACCEL_BIAS]
    assert np.all(np.abs(bias) < 4 * sigma)
    smoothed = np.array([p - flight.p(np.array(t)) for t, p, _ in tight.smoothed()])
    assert np.linalg.norm(smoothed[100:-20], axis=1).mean() < 0.03


@pytest.mark.proof
@pytest.mark.parametrize("seed", range(2))
def test_lever_arm_and_late_stamps_are_found_within_their_sigma(seed: int) -> None:
    flight, rng = Eight(16.0), np.random.default_rng(seed)
    imu, fixes = flight.imu(rng, EARTH), flight.fixes(rng, LEVER, late=0.12)
    aligned = align_when_possible(MovingAligner(NOISE, GRAVITY, EARTH, ZERO, 1.0, 0.2), imu, fixes)
    assert isinstance(aligned, AlignmentState)
    assert abs(aligned.time_offset + 0.12) < 4 * np.sqrt(aligned.covariance[15, 15])
    settings = WindowSettings(SITE, aligned.lever, lever_std=1.0, offset_std=0.2)
    source = InertialWindow(settings, imu, fixes.shifted(aligned.time_offset), aligned)
    poses = list(source.poses())
    antenna = poses[-1].antenna
    assert antenna is not None
    off = np.r_[antenna.lever - LEVER, aligned.time_offset + antenna.time_offset + 0.12]
    assert off @ np.linalg.solve(antenna.covariance, off) < 18.5  # 0.1 % of four
    sigma = np.sqrt(np.diag(antenna.covariance))
    assert sigma[:3].max() < 0.12
    assert sigma[3] < 0.01


@pytest.mark.proof
def test_two_layers_reach_what_one_does(flight: Eight) -> None:
    source = window(flight, 1, layers=2)
    poses = [pose for pose in PoseGraph().run(source, source.fixes) if pose.t > 8.0]
    error = np.array([pose.p - flight.p(np.array(pose.t)) for pose in poses])
    assert np.linalg.norm(error, axis=1).mean() < 0.06
    truth = flight.attitude(np.array([pose.t for pose in poses])).as_matrix()
    turn = np.array([pose.C_nb for pose in poses]) @ truth.transpose(0, 2, 1)
    assert np.degrees(np.arccos(np.clip(turn[:, 2, 2], -1, 1))).max() < 1.0
    assert np.degrees(np.abs(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))).max() < 5.0


@pytest.mark.proof
def test_two_layers_smooth_an_outage_as_one_does() -> None:
    """What the first velocities behind it tell of an outage is no motion: handed on as one it cost metres."""
    imu, fixes, aligned = aligned_flight(flight := Eight(25.0), 1)
    fixes = fixes.part(((fixes.t < 9.0) | (fixes.t > 15.0)) & (fixes.t < 18.0))
    imu = between(imu, 0.0, 18.0)
    one, two = (InertialWindow(WindowSettings(SITE, ZERO, layers), imu, fixes, aligned) for layers in (1, 2))
    at_its_end = [pose for pose in one.poses() if pose.t < 15.0][-1]
    graph = PoseGraph()
    reported = [pose.p - flight.p(np.array(pose.t)) for pose in graph.run(two, fixes) if pose.t > 15.5]
    assert np.linalg.norm(at_its_end.p_o - flight.p(np.array(at_its_end.t))) > 0.5  # it had to be found again
    assert np.linalg.norm(reported, axis=1).mean() < 0.15
    tight, (found, rejected) = one.smoothed(), graph.smoothed()
    off_one = np.linalg.norm([p - flight.p(np.array(t)) for t, p, _ in tight if 9.0 < t < 15.0], axis=1)
    out = (found.t > 9.0) & (found.t < 15.0)
    off_two = np.linalg.norm(found.p[out] - flight.p(found.t[out]), axis=1)
    assert off_two.max() < 1.5 * off_one.max()  # of one draw: medians are the benchmark's
    assert off_two.mean() < 1.5 * off_one.mean()
    assert rejected == 0


def test_a_fog_on_the_bench_keeps_north_to_what_its_east_bias_explains() -> None:
    rng = np.random.default_rng(3)
    bias = rng.normal(size=3) * 0.05 * RAD_S_PER_DEG_H
    imu, C_nb, noise = fog(rng, 300.0, bias)
    start = align_at_rest(imu, noise, GRAVITY, EARTH)
    assert isinstance(start, AlignmentState)
    start = replace(start, C_nb=_turned(10.0) @ start.C_nb)
    nan = np.full((1, 3), np.nan)
    none = GnssFixes(imu.t[:1], np.zeros((1, 3)), nan, nan[:, 0], np.ones(1), nan[:, 0])
    bench = InertialWindow(
        WindowSettings(Site(GRAVITY, EARTH, noise), ZERO, still_std=1e-3, spacing=1.0, frames=20), imu, none, start
    )
    *_, last = bench.poses()
    E = last.C_ob @ C_nb.T
    yaw = np.degrees(E[1, 0] - E[0, 1]) / 2
    assert abs(yaw - np.degrees((C_nb @ bias)[0] / EARTH[1])) < 0.2
    sigma = np.degrees(np.sqrt(bench.covariance_n[3, 3]))
    assert 0.3 < sigma < 0.5


def _turned(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
