"""Which poses are known otherwise by now, when an outage is looked back on, and how its steps err: by hand."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.inner.left_keyframes import Left
from procedures.fusion.inner.way_handed_on import WayHandedOn
from procedures.fusion.inner.window_factor import Factor
from procedures.fusion.inner.window_problem import Gone, Held
from procedures.fusion.inner.window_state import COMMON, FRAME, PLACE, WindowState
from procedures.fusion.odometry import OdometryPose

RNG = np.random.default_rng(1)


def pose(t: float, p: FloatArray | None = None) -> OdometryPose:
    return OdometryPose(t, np.zeros(3) if p is None else p, np.eye(3), np.diag([1.0, 1.0, 1.0, 2.0]))


def state(p: FloatArray) -> WindowState:
    """Return keyframes at places (k, 3)."""
    none, turns = np.zeros((len(p), 3)), np.tile(np.eye(3), (len(p), 1, 1))
    turns[:, 0, 0] = np.arange(len(p))  # told apart by it
    return WindowState(turns, p, none, none, none, np.eye(3), np.zeros(3), 0.0, np.zeros((0, 3)))


def unmoved(p: FloatArray) -> Left:
    """Return a keyframe that left from ``p`` and stays there whatever follows does."""
    two = state(np.stack((p, np.zeros(3))))
    gone = Gone(np.zeros((FRAME, COMMON + FRAME + 1)), Factor(np.eye(FRAME)))
    return Left(two, Held([], []), gone)


def problem(frames: int) -> FloatArray:
    J = RNG.normal(size=(3 * COMMON + 2 * FRAME * frames, COMMON + FRAME * frames))
    A: FloatArray = J.T @ J
    return A


def way(times: FloatArray) -> WayHandedOn:
    found = WayHandedOn()
    for t in times:
        found.add(pose(float(t)))
    return found


def test_without_an_outage_a_keyframe_that_leaves_takes_its_pose_with_it() -> None:
    found = way(np.arange(4.0))
    assert found.open_since == 0.0
    found.slid(unmoved(np.zeros(3)))
    assert [each.t for each in found.poses] == [1.0, 2.0, 3.0]
    assert not any(found.listen(has_velocity=True, is_outage=False) for _ in range(5))
    assert WayHandedOn().open_since is None


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


def test_an_outage_is_looked_back_on_at_its_first_fourth_sixteenth_and_64th_velocity() -> None:
    found = way(np.arange(3.0))
    assert not found.listen(has_velocity=False, is_outage=True)
    found.slid(unmoved(np.zeros(3)))
    assert len(found.poses) == 3  # kept
    asked = list[int]()
    for heard in range(1, 100):
        found.add(pose(3.0 + 0.01 * heard))
        if found.listen(has_velocity=True, is_outage=False):
            asked.append(heard)
        assert not found.listen(has_velocity=False, is_outage=False)
    assert asked == [1, 4, 16, 64]


def test_five_seconds_behind_its_end_an_outage_is_settled_and_left() -> None:
    found = way(np.arange(3.0))
    found.listen(has_velocity=False, is_outage=True)
    found.slid(unmoved(np.zeros(3)))
    found.add(pose(3.0))  # its last, without a velocity
    assert found.listen(has_velocity=True, is_outage=False)  # of the keyframe that becomes the pose at 4 s
    found.add(pose(4.0))
    for t in (6.0, 9.0):
        found.add(pose(t))
        assert not found.listen(has_velocity=False, is_outage=False)
    found.add(pose(9.1))
    assert found.listen(has_velocity=False, is_outage=False)
    found.revise(state(RNG.normal(size=(7, 3))), Factor(problem(7)), 0.0, looks_back=True)
    assert found.open_since == 1.0  # the one whose keyframe had left is gone
    assert not found.listen(has_velocity=True, is_outage=False)


def test_a_second_outage_begins_anew_once_velocities_came_between() -> None:
    found = way(np.arange(3.0))
    found.listen(has_velocity=False, is_outage=True)
    found.slid(unmoved(np.zeros(3)))
    found.listen(has_velocity=False, is_outage=True)  # still the same
    assert found.open_since == 0.0
    assert found.listen(has_velocity=True, is_outage=False)
    found.listen(has_velocity=False, is_outage=True)
    assert found.open_since == 1.0
    assert found.listen(has_velocity=True, is_outage=False)  # its first


def test_an_outage_of_more_than_two_minutes_is_kept_for_two() -> None:
    found = way(np.arange(3.0))
    found.listen(has_velocity=False, is_outage=True)
    for k in range(2):
        found.slid(unmoved(np.full(3, k)))
    found.add(pose(120.0))
    assert found.open_since == 0.0
    found.add(pose(120.5))
    assert found.open_since == 1.0
    found.listen(has_velocity=True, is_outage=False)
    found.add(pose(122.0))  # it has ended: nothing more is given up
    assert found.open_since == 1.0


@pytest.mark.parametrize("least", [0.0, 1e-3, 10.0])
def test_the_steps_of_an_outage_have_twice_their_covariance_with_its_way(least: float) -> None:
    times = np.array([0.0, 1.0, 1.5, 3.5, 4.0])
    found = way(times[:4])
    found.listen(has_velocity=False, is_outage=True)
    found.listen(has_velocity=True, is_outage=False)  # it ends at the fifth keyframe
    found.add(pose(4.0))
    A = problem(6)
    found.revise(state(RNG.normal(size=(6, 3))), Factor(A), least, looks_back=True)
    P = np.linalg.inv(A)
    at = [np.arange(COMMON + FRAME * k, COMMON + FRAME * (k + 1))[PLACE] for k in range(6)]
    ends = P[:, at[4]] - P[:, at[0]]
    for k in range(1, 5):
        both = ends[at[k]] - ends[at[k - 1]]
        size, axes = np.linalg.eigh(2.0 * (both + both.T) / 2)
        expected = axes @ np.diag(np.maximum(size, least * (times[k] - times[k - 1]))) @ axes.T
        np.testing.assert_allclose(found.poses[k].drift[:3, :3], expected, rtol=1e-8, atol=1e-12)
        assert found.poses[k].drift[3, 3] == 2.0
    np.testing.assert_array_equal(found.poses[0].drift, pose(0.0).drift)
