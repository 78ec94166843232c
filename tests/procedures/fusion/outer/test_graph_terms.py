"""The outer graph's terms beside the residuals that its page prints, slopes by differences; the yaw by track."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fix_association import track_yaw
from procedures.fusion.pose_graph_terms import (
    FixTerms,
    NodeLayout,
    NodePrior,
    OdometrySteps,
    linearise,
    rz,
)

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
