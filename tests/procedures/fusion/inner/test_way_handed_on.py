"""Which poses are known otherwise by now, when an outage is looked back on, and how its steps err: by hand."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.inner.way_handed_on import WayHandedOn
from procedures.fusion.inner.window_factor import Factor
from procedures.fusion.inner.window_state import COMMON, FRAME, WindowState
from procedures.fusion.odometry import OdometryPose

RNG = np.random.default_rng(1)


def pose(t: float, p: FloatArray | None = None) -> OdometryPose:
    return OdometryPose(t, np.zeros(3) if p is None else p, np.eye(3), np.diag([1.0, 1.0, 1.0, 2.0]))


def state(p: FloatArray) -> WindowState:
    """Return keyframes at places (k, 3)."""
    none, turns = np.zeros((len(p), 3)), np.tile(np.eye(3), (len(p), 1, 1))
    turns[:, 0, 0] = np.arange(len(p))  # told apart by it
    return WindowState(turns, p, none, none, none, np.eye(3), np.zeros(3), 0.0, np.zeros((0, 3)))


def problem(frames: int) -> FloatArray:
    J = RNG.normal(size=(3 * COMMON + 2 * FRAME * frames, COMMON + FRAME * frames))
    A: FloatArray = J.T @ J
    return A


def test_poses_are_handed_on_anew_by_their_steps_from_the_oldest_that_stays() -> None:
    found, p = WayHandedOn(), RNG.normal(size=(4, 3))
    for k in range(3):
        found.add(pose(float(k), 10.0 + np.full(3, k)))
    revised = found.revise(state(p), Factor(problem(4)), 0.0, looks_back=False)
    assert [each.t for each in revised] == [1.0, 2.0]
    for k in (1, 2):
        np.testing.assert_allclose(found.poses[k].p_o, 10.0 + p[k] - p[0], rtol=1e-12)
        assert found.poses[k].C_ob[0, 0] == k
        np.testing.assert_array_equal(found.poses[k].drift, pose(0.0).drift)
    np.testing.assert_array_equal(found.poses[0].p_o, [10.0, 10.0, 10.0])
    np.testing.assert_allclose(found.newest(state(p)), 10.0 + p[3] - p[0], rtol=1e-12)
