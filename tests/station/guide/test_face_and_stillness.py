"""Faces by raw counts alone, and dwells of a cube that is set down smoothly."""

import numpy as np
import pytest

from procedures.frames import rotation
from procedures.positions import FACES, face_normal
from station.guide.checks.dwell_attempt import CHANGED_BLOCKS, POSITION_CHANGED, DwellAttempt
from station.guide.checks.face_and_stillness import BlockLook, FaceAndStillnessGate, opposite_faces
from station.stream.live.stillness import Block


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


def test_two_opposite_faces_determine_the_biases_and_the_limit_widens() -> None:
    judge, bias = FaceAndStillnessGate(np.eye(3)), np.array([5.0, -30.0, 12.0])
    before = judge.limit_deg
    for up, down in opposite_faces():
        judge.learn_faces({name: 1000 * face_normal(name) + bias for name in (up, down)})
        assert judge.seen_face(1000 * face_normal(up) + bias)[1] < 0.01
    assert before < judge.limit_deg < 3.0
    assert len(opposite_faces()) == 3


SAMPLES = 50
SIGMA = np.full(6, 0.8)  # count/s of a block, the least a counter shows
REST = np.array([0.4, 0.0, 0.2, 0.0, 1.0, 1000.0])
LOWERED = REST - np.array([0, 0, 0, 0, 0, 23.0])  # 23 mg of 1000 count/(g s)
LOOK = BlockLook("z_up", 0.2, 1.0, "az", True, True, True, SIGMA, "")


def block(number: int, rate: np.ndarray) -> Block:
    first, last = number * SAMPLES, (number + 1) * SAMPLES
    return Block(first, last, rate, np.zeros(6), number, number + 1.0, 23.0, True, False, False)


def dwelling(seconds: int) -> DwellAttempt:
    return DwellAttempt(seconds * SAMPLES, 1 / SAMPLES, lambda rate: 1e6)


def test_seconds_in_which_the_cube_was_still_lowered_are_dropped_by_those_that_followed() -> None:
    one = dwelling(10)
    for number, rate in enumerate([LOWERED, *[REST] * 20]):
        one.take(block(number, rate), LOOK)
        if one.is_complete:
            break
    one.drop_unstill(lambda each: True)
    assert [each.first for each in one.kept][:1] == [SAMPLES]
    assert not one.is_complete


def test_a_dwell_that_began_before_the_cube_stood_begins_again_instead_of_waiting_for_ever() -> None:
    one = dwelling(60)
    reported = [one.take(block(i, rate), LOOK) for i, rate in enumerate([*[LOWERED] * 8, *[REST] * 30])]
    assert POSITION_CHANGED in reported
    assert reported.index(POSITION_CHANGED) == 8 + CHANGED_BLOCKS - 1


@pytest.mark.parametrize("disturbed", [1, 4])
def test_a_short_bump_is_no_other_stand(disturbed: int) -> None:
    one = dwelling(60)
    rates = [*[REST] * 10, *[LOWERED] * disturbed, *[REST] * 20]
    assert POSITION_CHANGED not in [one.take(block(i, rate), LOOK) for i, rate in enumerate(rates)]
