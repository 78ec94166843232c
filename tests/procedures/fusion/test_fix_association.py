"""Fixes tied to an odometry's poses: numbers of one corner, and what is kept when poses are revised."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fix_association import FixAssociation
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.pose_graph_terms import FixTerms

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
