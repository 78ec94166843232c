"""The outer graph finds planted truth within its own sigma: outages, outliers, lever arm and late stamps."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fix_association import track_yaw
from procedures.fusion.fusion_records import Trajectory
from procedures.fusion.odometry import OdometryDrift, RecordedOdometry
from procedures.fusion.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings
from procedures.fusion.pose_graph_terms import (
    BlockTridiagonal,
    FixTerms,
    NodeLayout,
    NodePrior,
    OdometrySteps,
    eliminate,
    linearise,
    rz,
    solve_chain,
)
from tests.procedures.fusion.motions import Eight, only

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
    poses = list(graph.run(flight.odometry(rng, DRIFT), flight.fixes(rng)))
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
    last = list(graph.run(odometry, fixes))[-1]
    assert np.abs(graph.smoothed()[0].p[-1] - last.p).max() < 0.01  # by what Huber weights froze: noise is 0.2


def test_each_pose_uses_nothing_later() -> None:
    flight, rng = Eight(20.0), np.random.default_rng(2)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    poses = list(PoseGraph().run(odometry, fixes))
    half = only(fixes, fixes.t < 10.0)
    cut = RecordedOdometry(
        Trajectory(
            *(part[:201] for part in (odometry.trajectory.t, odometry.trajectory.p, odometry.trajectory.q))
        ),
        DRIFT,
    )
    early = list(PoseGraph().run(cut, half))
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
    calm = np.linalg.norm(errors(list(clean.run(odometry, fixes)), flight), axis=1).mean()
    shaken = np.linalg.norm(errors(list(graph.run(odometry, replace(fixes, p_n=p))), flight), axis=1).mean()
    assert shaken < 1.25 * calm
    assert clean.smoothed()[1] == 0
    assert graph.smoothed()[1] == len(away)


def test_an_outage_is_bridged_with_growing_sigma() -> None:
    flight, rng = Eight(), np.random.default_rng(4)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    poses = list(PoseGraph().run(odometry, only(fixes, (fixes.t < 30) | (fixes.t > 50))))
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
    poses = list(graph.run(flight.odometry(rng, DRIFT), fixes))
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
    assert not list(graph.run(flight.odometry(rng, DRIFT), replace(fixes, p_n=3 * fixes.p_n, v_n=-3 * fixes.v_n)))
    assert "does not match that of GNSS" in graph.why_not


N, GIVEN = 4, np.array([0.3, -0.2, 0.5])


def terms(rng: np.random.Generator) -> tuple[OdometrySteps, FixTerms]:
    drift = np.array([a @ a.T + np.eye(4) for a in rng.normal(0, 0.3, (N - 1, 4, 4))])
    node = np.array([1, 2, 2])
    fixes = FixTerms(
        node=node, arm_o=rng.normal(size=(3, 3)), C_of=Rotation.random(3, random_state=1).as_matrix(),
        v_o=rng.normal(size=(3, 3)), tau=np.array([0.1, 0.1, 0.2]), z=rng.normal(size=(3, 3)),
        weight=np.array([0.01, 0.02, 0.015]), course=np.array([0.2, 3.0, -3.0]),
        course_weight=np.array([0.3, 0.04, 0.0]),
    )  # fmt: skip
    return OdometrySteps(rng.normal(size=(N - 1, 3)), np.linalg.inv(drift)), fixes


def turned(yaw: float) -> FloatArray:
    return np.asarray(Rotation.from_euler("z", yaw).as_matrix())


def whitened(
    x: FloatArray, nodes: OdometrySteps, fixes: FixTerms, prior: NodePrior, layout: NodeLayout
) -> FloatArray:
    """Return all residuals, each of unit variance: half of their squares is the cost."""
    d, found = layout.size, list[FloatArray]()
    found.append(np.linalg.cholesky(prior.info).T @ (x[0] - prior.at))
    for i in range(N - 1):
        step = np.r_[x[i + 1, :3] - x[i, :3] - turned(x[i, 3]) @ nodes.step_o[i], x[i + 1, 3] - x[i, 3]]
        found += [np.linalg.cholesky(nodes.info[i]).T @ step, (x[i + 1, 4:d] - x[i, 4:d]) / 1e-4]
    for k, i in enumerate(fixes.node):
        lever = x[i, 4:7] if layout.lever_arm else GIVEN
        late = x[i, -1] - fixes.tau[k] if layout.time_offset else 0.0
        arm = fixes.arm_o[k] + fixes.C_of[k] @ lever + fixes.v_o[k] * late
        found.append(math.sqrt(fixes.weight[k]) * (x[i, :3] + turned(x[i, 3]) @ arm - fixes.z[k]))
        off = math.remainder(fixes.course[k] - x[i, 3], 2 * math.pi)
        found.append(np.array([math.sqrt(fixes.course_weight[k]) * off]))
    return np.concatenate(found)


@pytest.mark.parametrize("layout", [NodeLayout(a, b) for a in (False, True) for b in (False, True)])
def test_the_normal_equations_are_those_of_the_residuals(layout: NodeLayout) -> None:
    rng, d = np.random.default_rng(4), layout.size
    nodes, fixes = terms(rng)
    x = rng.normal(0, 0.5, (N, d))
    x[:, 4:] = x[0, 4:] + rng.normal(0, 1e-4, (N, d - 4))
    root = rng.normal(size=(d, d))
    prior = NodePrior(root @ root.T + np.eye(d), np.zeros(d), rng.normal(size=d))
    chain, size = linearise(x, nodes, fixes, prior, layout, GIVEN)
    J = np.zeros((len(whitened(x, nodes, fixes, prior, layout)), N * d))
    for column in range(N * d):
        step = np.zeros(N * d)
        step[column] = 1e-6
        ahead, back = (whitened(x + s * step.reshape(N, d), nodes, fixes, prior, layout) for s in (1, -1))
        J[:, column] = (ahead - back) / 2e-6
    H = (J.T @ J).reshape(N, d, N, d)
    for i in range(N):
        np.testing.assert_allclose(chain.D[i], H[i, :, i], rtol=1e-5, atol=1e-5)
        if i < N - 1:
            np.testing.assert_allclose(chain.U[i], H[i, :, i + 1], rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(
        chain.g.ravel(), J.T @ whitened(x, nodes, fixes, prior, layout), rtol=1e-5, atol=1e-5
    )
    r = whitened(x, nodes, fixes, prior, layout)
    steps_end = d + (N - 1) * d
    expected = np.linalg.norm(r[steps_end:].reshape(3, 4)[:, :3], axis=1)
    np.testing.assert_allclose(size, expected)


def test_a_turn_about_the_vertical_and_its_derivative() -> None:
    R, dR = rz(np.array([0.3, -2.0]))
    np.testing.assert_allclose(R, [turned(0.3), turned(-2.0)], atol=1e-15)
    slope = [(turned(a + 1e-6) - turned(a - 1e-6)) / 2e-6 for a in (0.3, -2.0)]
    np.testing.assert_allclose(dR, slope, atol=1e-9)


def turn(points: FloatArray, yaw: float) -> FloatArray:
    return points @ turned(yaw)[:2, :2].T


TRACK = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]])  # rms about its mean: sqrt(5) m


@pytest.mark.parametrize("yaw", [0.7, -2.9])
def test_the_yaw_by_track_has_the_sigma_of_its_fixes(yaw: float) -> None:
    nothing = np.full((4, 2), np.nan)
    found = track_yaw(
        TRACK, turn(TRACK, yaw) + np.array([100.0, 50.0]), np.full(4, 0.2), nothing, nothing, np.ones(4), 0.0
    )
    assert found.yaw == pytest.approx(yaw)
    assert found.spread == pytest.approx(math.sqrt(5.0))
    assert found.misfit == pytest.approx(0.0, abs=1e-20)
    assert found.std == pytest.approx(0.2 / math.sqrt(20.0))
