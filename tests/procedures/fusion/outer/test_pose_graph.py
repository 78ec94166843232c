"""The outer graph finds planted truth within its own sigma: outages, outliers, lever arm and late stamps."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.fusion.fusion_records import Trajectory
from procedures.fusion.odometry import OdometryDrift, RecordedOdometry
from procedures.fusion.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from procedures.fusion.pose_graph_terms import BlockTridiagonal, eliminate, solve_chain
from tests.procedures.fusion.motions import Eight, only
from tests.procedures.fusion.whole_runs import whole_run

DRIFT = OdometryDrift(0.02, 0.03, 0.01)
LEVER = np.array([0.3, -0.2, 0.5])


def errors(poses: list[GlobalPose], flight: Eight) -> np.ndarray:
    """Return position errors (n, 3) [m] of online poses."""
    return np.array([pose.p - flight.p(np.array(pose.t)) for pose in poses])


def test_a_chain_is_solved_as_the_dense_matrix_is() -> None:
    rng = np.random.default_rng(1)
    n, d = 6, 3
    J = np.zeros((n * d * 2, n * d))
    for i in range(n):  # rows that touch a node and the next
        J[2 * d * i : 2 * d * (i + 1), d * i : d * (i + 2)] = rng.normal(
            size=(2 * d, len(J[0, d * i : d * (i + 2)]))
        )
    H, g = J.T @ J, rng.normal(size=n * d)
    D = np.array([H[d * i : d * (i + 1), d * i : d * (i + 1)] for i in range(n)])
    U = np.array([H[d * i : d * (i + 1), d * (i + 1) : d * (i + 2)] for i in range(n - 1)])
    step, covariance = solve_chain(BlockTridiagonal(D, U, g.reshape(n, d)))
    assert np.allclose(step.ravel(), np.linalg.solve(H, -g), rtol=1e-9)
    assert np.allclose(covariance, np.linalg.inv(H)[-d:, -d:], rtol=1e-9)
    info, gradient = eliminate(D[0], U[0], g[:d])
    D[1] += info
    rest = BlockTridiagonal(D[1:], U[1:], np.vstack((g[d : 2 * d] + gradient, g[2 * d :].reshape(-1, d))))
    assert np.allclose(solve_chain(rest)[0], step[1:], rtol=1e-9)


@pytest.mark.proof
@pytest.mark.parametrize("seed", range(2))
def test_position_and_yaw_are_found_within_their_own_sigma(seed: int) -> None:
    flight, rng = Eight(), np.random.default_rng(seed)
    graph = PoseGraph()
    poses = whole_run(graph, flight.odometry(rng, DRIFT), flight.fixes(rng))
    assert graph.begun_at is not None
    assert graph.begun_at < 10.0
    nees = [
        e @ np.linalg.solve(p.covariance[:3, :3], e) / 3 for p, e in zip(poses, errors(poses, flight), strict=True)
    ]
    assert 0.5 < np.mean(nees) < 1.6  # some 40 independent stretches of 3 axes
    truth = flight.attitude(np.array([pose.t for pose in poses])).as_matrix()
    turn = np.array([p.C_nb for p in poses]) @ truth.transpose(0, 2, 1)
    yaw = np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
    sigma = np.sqrt([p.covariance[3, 3] for p in poses])
    assert np.sqrt(np.mean((yaw / sigma) ** 2)) < 2.0
    assert np.abs(turn[:, 2, 2] - 1).max() < 1e-9  # roll and pitch are the odometry's


def test_what_leaves_the_window_is_not_lost() -> None:
    flight, rng = Eight(40.0), np.random.default_rng(5)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    graph = PoseGraph(PoseGraphSettings(window=3.0))
    last = whole_run(graph, odometry, fixes)[-1]
    assert np.abs(graph.smoothed()[0].p[-1] - last.p).max() < 0.01  # by what Huber weights froze: noise is 0.2


def test_each_pose_uses_nothing_later() -> None:
    flight, rng = Eight(20.0), np.random.default_rng(2)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    poses = whole_run(PoseGraph(), odometry, fixes)
    half = only(fixes, fixes.t < 10.0)
    cut = RecordedOdometry(
        Trajectory(
            *(part[:201] for part in (odometry.trajectory.t, odometry.trajectory.p, odometry.trajectory.q))
        ),
        DRIFT,
    )
    early = whole_run(PoseGraph(), cut, half)
    assert all(np.array_equal(a.p, b.p) for a, b in zip(early[:-1], poses, strict=False))


@pytest.mark.proof
def test_outliers_are_counted_and_cost_little() -> None:
    flight, rng = Eight(), np.random.default_rng(3)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    away = np.flatnonzero(rng.random(len(fixes.t)) < 0.1)
    off = rng.normal(size=(len(away), 3))
    p = fixes.p_n.copy()
    p[away] += 5 * off / np.linalg.norm(off, axis=1)[:, None]
    clean, graph = PoseGraph(), PoseGraph()
    calm = np.linalg.norm(errors(whole_run(clean, odometry, fixes), flight), axis=1).mean()
    shaken = np.linalg.norm(errors(whole_run(graph, odometry, replace(fixes, p_n=p)), flight), axis=1).mean()
    assert shaken < 1.25 * calm
    assert clean.smoothed()[1] == 0
    assert graph.smoothed()[1] == len(away)


def test_an_outage_is_bridged_with_growing_sigma() -> None:
    flight, rng = Eight(), np.random.default_rng(4)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    poses = whole_run(PoseGraph(), odometry, only(fixes, (fixes.t < 30) | (fixes.t > 50)))
    out = [pose for pose in poses if 30 < pose.t < 50]
    sigma = np.array([np.sqrt(np.trace(pose.covariance[:3, :3])) for pose in out])
    assert sigma[-1] > 4 * sigma[0]
    assert np.linalg.norm(errors(out, flight)[-1]) < 3 * sigma[-1]
    assert np.linalg.norm(errors(poses, flight)[-1]) < 0.2


@pytest.mark.parametrize("seed", range(2))
def test_lever_arm_and_late_stamps_are_found_within_their_sigma(seed: int) -> None:
    flight, rng = Eight(30.0), np.random.default_rng(seed)
    fixes = flight.fixes(rng, LEVER, late=0.15)
    graph = PoseGraph(PoseGraphSettings(lever_arm_std=1.0, time_offset_std=0.2))
    poses = whole_run(graph, flight.odometry(rng, DRIFT), fixes)
    lever, offset = graph.constants
    assert np.linalg.norm(lever - LEVER) < 4 * graph.lever_std
    assert abs(offset + 0.15) < 4 * graph.offset_std
    assert graph.lever_std < 0.25
    assert graph.offset_std < 0.01
    assert np.linalg.norm(errors(poses, flight), axis=1)[-200:].mean() < 0.25


def test_tracks_that_are_not_the_same_motion_are_refused() -> None:
    flight, rng = Eight(30.0), np.random.default_rng(8)
    fixes = flight.fixes(rng)
    graph = PoseGraph()
    assert not whole_run(graph, flight.odometry(rng, DRIFT), replace(fixes, p_n=3 * fixes.p_n, v_n=-3 * fixes.v_n))
    assert "does not match that of GNSS" in graph.why_not
