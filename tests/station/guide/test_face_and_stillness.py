"""Faces by raw counts alone."""

import numpy as np
import pytest

from procedures.frames import FACES, face_normal, rotation
from station.guide.face_and_stillness import FaceAndStillnessGate, opposite_faces


@pytest.mark.parametrize("face", FACES)
def test_each_face_is_recognised(face: str) -> None:
    seen, off = FaceAndStillnessGate(np.eye(3)).seen_face(1000 * face_normal(face) + [20, -15, 8])
    assert seen == face
    assert off < 2.0


def test_a_tilt_is_seen_as_its_angle() -> None:
    accel = rotation(np.array([0.0, np.radians(20.0), 0.0])) @ np.array([1000.0, 0.0, 0.0])
    assert FaceAndStillnessGate(np.eye(3)).seen_face(accel) == ("x_up", pytest.approx(20.0))


def test_a_turned_mounting_is_taken_into_account() -> None:
    C_sb = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # IMU x along cube y, y along -x
    assert FaceAndStillnessGate(C_sb).seen_face(C_sb @ (1000 * face_normal("x_up")))[0] == "x_up"


def test_two_opposite_faces_tell_the_biases_and_the_limit_widens() -> None:
    judge, bias = FaceAndStillnessGate(np.eye(3)), np.array([5.0, -30.0, 12.0])
    before = judge.limit_deg
    for up, down in opposite_faces():
        judge.learn_faces({name: 1000 * face_normal(name) + bias for name in (up, down)})
        assert judge.seen_face(1000 * face_normal(up) + bias)[1] < 0.01
    assert before < judge.limit_deg < 3.0
    assert len(opposite_faces()) == 3
