"""Fixes tied to an odometry's poses: numbers of one corner, and what is kept when poses are revised."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.outer.fix_association import FixAssociation
from procedures.fusion.outer.pose_graph_terms import FixTerms
from procedures.fusion.outer.track_yaw import track_yaw

LEVER = np.array([0.3, -0.2, 0.5])
T = np.array([10.0, 10.5, 11.5, 12.0])
P_O = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [2.0, 3.0, 0.3], [1.0, 4.0, 0.3]])
C_OB = Rotation.from_euler(
    "ZYX", [[0.0, 0.1, 0.0], [0.3, 0.0, 0.1], [1.0, 0.0, -0.2], [1.4, 0.1, 0.0]]
).as_matrix()
DRIFT = np.array([np.diag([0.01, 0.01, 0.01, 1e-4]) * (i + 1) for i in range(4)])


def pose(i: int) -> OdometryPose:
    return OdometryPose(float(T[i]), P_O[i], C_OB[i], DRIFT[i], yaw_std=0.1 * i)


def fixes(*t: float) -> GnssFixes:
    n = len(t)
    v = np.tile([[1.0, 2.0, 0.1]], (n, 1))
    return GnssFixes(
        np.array(t), np.arange(3.0 * n).reshape(n, 3), v, np.full(n, 0.4), np.full(n, 0.2), np.full(n, 0.1)
    )


def associated(given: GnssFixes, offset: float = 0.0, poses: int = 4) -> FixAssociation:
    made = FixAssociation(LEVER, offset)
    made.fixes = given
    for i in range(poses):
        made.add(pose(i))
    return made


def only(made: FixAssociation) -> FixTerms:
    return made.window(0)[1]


def test_a_fix_is_tied_by_the_straight_motion_between_two_poses() -> None:
    found = only(associated(fixes(10.8), offset=0.1))  # at 10.9: 0.6 s before the pose at 11.5
    v_o = P_O[2] - P_O[1]
    assert found.node.tolist() == [2]
    np.testing.assert_allclose(found.arm_o[0], -0.6 * v_o)
    np.testing.assert_allclose(found.C_of[0], 0.6 * C_OB[1] + 0.4 * C_OB[2])
    v_antenna = v_o + (C_OB[2] - C_OB[1]) @ LEVER
    np.testing.assert_allclose(found.v_o[0], v_antenna)
    assert found.tau.tolist() == [0.1]
    assert found.z[0].tolist() == [0.0, 1.0, 2.0]
    assert found.weight[0] == pytest.approx(1 / (0.2**2 + (0.5 * 2.0 * 0.4**2) ** 2))  # 2 m/s2 for 0.4 s
    course = math.atan2(2.0, 1.0) - math.atan2(v_antenna[1], v_antenna[0])
    assert found.course[0] == pytest.approx(course)
    speed = math.hypot(*v_antenna[:2])
    variance = math.radians(4.0) ** 2 + (0.1**2 + 0.03) / speed**2  # the step's drift is 0.03 m2 in 1 s
    assert found.course_weight[0] == pytest.approx(1 / variance)


def test_the_motion_is_per_second_of_the_step() -> None:
    found = only(associated(fixes(11.9)))  # 0.1 of a step of 0.5 s
    v_o = (P_O[3] - P_O[2]) / 0.5
    np.testing.assert_allclose(found.arm_o[0], -0.1 * v_o)
    np.testing.assert_allclose(found.C_of[0], 0.2 * C_OB[2] + 0.8 * C_OB[3])
    v_antenna = v_o + (C_OB[3] - C_OB[2]) @ LEVER / 0.5
    np.testing.assert_allclose(found.v_o[0], v_antenna)
    assert found.weight[0] == pytest.approx(1 / (0.04 + (0.1**2) ** 2))
    speed = math.hypot(*v_antenna[:2])
    variance = math.radians(4.0) ** 2 + (0.01 + 0.04 / 0.25) / speed**2
    assert found.course_weight[0] == pytest.approx(1 / variance)


@pytest.mark.parametrize(("heading", "expected"), [(0.4, math.pi / 2 - 0.4), (-3.0, -3.0)])
def test_a_course_alone_is_from_north_to_east_and_within_half_a_turn(heading: float, expected: float) -> None:
    given = fixes(10.8)
    given.v_n[:], given.course[:] = np.nan, heading
    made = associated(given)
    found = only(made)
    motion = found.v_o[0]
    off = math.remainder(math.pi / 2 - heading - math.atan2(motion[1], motion[0]), 2 * math.pi)
    assert found.course[0] == pytest.approx(off)
    assert found.course_weight[0] > 0.0
    assert expected != 0.0


def test_a_velocity_whose_vertical_part_is_missing_has_a_course() -> None:
    given = fixes(10.8)
    given.v_n[0, 2] = given.course[0] = np.nan
    assert only(associated(given)).course_weight[0] == only(associated(fixes(10.8))).course_weight[0] > 0.0


def test_what_gives_no_course_weighs_nothing() -> None:
    given = fixes(10.8)
    given.v_n[0, 0] = given.course[0] = np.nan
    assert only(associated(given)).course_weight.tolist() == [0.0]
    used = FixAssociation(LEVER, 0.0)
    used.fixes = fixes(10.8)
    for i in range(4):
        used.add(replace(pose(i), uses_velocity=True))
    assert only(used).course_weight.tolist() == [0.0]
    assert only(used).course.tolist() == [0.0]


@pytest.mark.parametrize(("way", "says"), [(0.24, False), (0.26, True)])
def test_below_half_a_metre_a_second_there_is_no_course(way: float, says: bool) -> None:
    made = FixAssociation(np.zeros(3), 0.0)
    made.fixes = fixes(10.2)
    for i in range(2):
        made.add(replace(pose(i), p_o=np.array([0.8 * way * i, -0.6 * way * i, 5.0 * i]), C_ob=np.eye(3)))
    assert (only(made).course_weight[0] > 0.0) == says


def test_fixes_are_taken_once_their_pose_is_there_and_none_before_the_first() -> None:
    made = FixAssociation(LEVER, 0.5)
    made.fixes = fixes(9.4, 9.5, 9.6, 10.0, 10.1, 11.5, 11.6)
    assert [made.add(pose(i)) for i in range(4)] == [0, 2, 1, 1]
    assert only(made).node.tolist() == [1, 1, 2, 3]
    np.testing.assert_allclose(only(made).z[:, 0], [6.0, 9.0, 12.0, 15.0])
    assert made.yaw_std == pytest.approx(0.3)
    step, drift = made.last_step()
    np.testing.assert_allclose(step, P_O[3] - P_O[2])
    np.testing.assert_allclose(drift, DRIFT[3])


def test_another_time_offset_ties_all_anew() -> None:
    made = associated(fixes(9.9, 10.4, 10.9))
    assert only(made).node.tolist() == [1, 2]
    made.associate_again(0.15)
    assert only(made).node.tolist() == [1, 2, 2]
    assert only(made).tau.tolist() == [0.15] * 3


def test_a_window_has_its_own_numbers_and_the_fixes_asked_for() -> None:
    made = associated(fixes(10.2, 10.8, 11.0, 11.7))
    steps, found = made.window(1)
    np.testing.assert_allclose(steps.step_o, np.diff(P_O[1:], axis=0))
    np.testing.assert_allclose(steps.info, np.linalg.inv(DRIFT[2:]))
    assert found.node.tolist() == [0, 1, 1, 2]
    steps, found = made.window(1, 3)
    np.testing.assert_allclose(steps.step_o, [P_O[2] - P_O[1]])
    assert found.node.tolist() == [0, 1, 1]
    assert made.window(1, fixes_of=1)[1].node.tolist() == [0]
    assert made.window(0, fixes_of=2)[1].node.tolist() == [1]


def test_revised_poses_stand_for_the_newest_and_their_fixes_are_tied_again() -> None:
    made = associated(fixes(10.2, 10.8, 11.7))
    before = only(made).arm_o.copy()
    other = [replace(pose(i), p_o=P_O[i] + [0.0, 0.0, i]) for i in (2, 3)]
    made.revise(other)
    np.testing.assert_allclose(made.p_o[:, 2], P_O[:, 2] + [0.0, 0.0, 2.0, 3.0])
    np.testing.assert_allclose(made.t, T)
    np.testing.assert_allclose(made.C_ob, C_OB)
    found = only(made)
    assert found.node.tolist() == [1, 2, 3]
    np.testing.assert_allclose(found.arm_o[0], before[0])
    np.testing.assert_allclose(found.arm_o[1:, 2] - before[1:, 2], [-0.7 * 2.0, -0.6 * 1.0])
    made.revise([replace(pose(0), t=0.0), *(pose(i) for i in range(4))])  # more than there are: the last ones
    np.testing.assert_allclose(made.t, T)
    np.testing.assert_allclose(made.p_o, P_O)


def test_many_nodes_and_fixes_are_kept() -> None:
    made = FixAssociation(np.zeros(3), 0.0)
    t = 10.0 + 0.1 * np.arange(600)
    made.fixes = fixes(*(t[1:] - 0.05))
    for i, each in enumerate(t):
        made.add(OdometryPose(float(each), np.array([i, 2.0 * i, 0.0]), np.eye(3), DRIFT[0]))
    np.testing.assert_allclose(made.p_o[:, 1], 2.0 * np.arange(600))
    assert only(made).node.tolist() == list(range(1, 600))


def test_the_track_is_the_antennas_and_its_velocity_is_blurred_by_how_fast_it_changes() -> None:
    made = associated(fixes(10.2, 10.9, 11.9))
    C = [0.6 * C_OB[0] + 0.4 * C_OB[1], 0.6 * C_OB[1] + 0.4 * C_OB[2], 0.2 * C_OB[2] + 0.8 * C_OB[3]]
    p = [0.6 * P_O[0] + 0.4 * P_O[1], 0.6 * P_O[1] + 0.4 * P_O[2], 0.2 * P_O[2] + 0.8 * P_O[3]]
    q, dt = np.array(p) + np.array(C) @ LEVER, np.diff(T)
    v = (np.diff(P_O, axis=0) + np.diff(C_OB, axis=0) @ LEVER) / dt[:, None]
    changed = [0.0, *np.linalg.norm(np.diff(v[:, :2], axis=0), axis=1)]
    std = np.sqrt(0.1**2 + 0.01 * np.array([2, 3, 4]) / dt**2 + np.square(changed) / 4)
    v_h = np.where((np.linalg.norm(v[:, :2], axis=1) > 3 * std)[:, None], v[:, :2], np.nan)
    assert np.isfinite(v_h[:, 0]).any()
    off = [0.5 * 2.0 * (0.2**2), 0.4**2, 0.1**2]
    given = made.fixes
    assert given is not None
    found = made.yaw_by_track()
    expected = track_yaw(
        q[:, :2], given.p_n[:, :2], np.hypot(0.2, off), v_h, given.v_n[:, :2], std, 0.01 * (2 + 3 + 4)
    )
    for name in ("yaw", "std", "spread", "misfit"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name)), name


def test_the_last_step_is_from_the_pose_before() -> None:
    step, drift = associated(fixes(10.2), poses=3).last_step()
    np.testing.assert_allclose(step, P_O[2] - P_O[1])
    np.testing.assert_allclose(drift, DRIFT[2])


def on_a_line(yaw: float, speed: float, n: int = 800) -> tuple[FixAssociation, FloatArray]:
    """Return a drive of 80 s to the odometry's x, whose frame is turned by ``yaw``, and its positions."""
    made = FixAssociation(LEVER, 0.0)
    t = 0.1 * np.arange(n)
    p_o = np.stack((speed * t, np.zeros(n), np.zeros(n)), axis=1)
    R = Rotation.from_euler("z", yaw).as_matrix()
    at = np.arange(5, n, 10)
    p_n, v_n = (p_o[at] + LEVER) @ R.T, np.tile(R @ [speed, 0.0, 0.0], (len(at), 1))
    made.fixes = GnssFixes(t[at], p_n, v_n, np.full(len(at), np.nan), np.full(len(at), 0.2), np.full(len(at), 0.1))
    for i in range(n):
        made.add(OdometryPose(float(t[i]), p_o[i], np.eye(3), np.diag([1e-6, 1e-6, 1e-6, 1e-8])))
    return made, p_o[at]


@pytest.mark.parametrize("speed", [0.2, 2.0])
def test_the_yaw_is_that_of_the_last_minute_of_track(speed: float) -> None:
    """Velocities below three sigma are noise: of 0.2 m/s positions alone speak."""
    made, p = on_a_line(-1.1, speed)
    found = made.yaw_by_track()
    recent = p[20:, 0]  # fixes after 19.9 s: at 20.5, 21.5 ... 79.5
    off, drift = recent - recent.mean(), (799 - 204) * 1e-6
    assert found.yaw == pytest.approx(-1.1)
    assert found.spread == pytest.approx(off.std())
    by_position = np.sum(off**2) / (0.04 + drift)
    v_variance = 0.1**2 + (1e-3 / 0.1) ** 2
    by_velocity = len(recent) * speed**2 / v_variance if speed > 3 * math.sqrt(v_variance) else 0.0
    systematic = min(drift / np.mean(off**2), 1 / by_velocity if by_velocity else np.inf)
    assert found.std == pytest.approx(math.sqrt(1 / (by_position + by_velocity) + systematic))
