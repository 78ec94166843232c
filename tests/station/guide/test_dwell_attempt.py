"""Dwells of a coarse counter whose cube is set down so smoothly that nothing trembles."""

import numpy as np
import pytest

from station.guide.dwell_attempt import OTHERWISE, OTHERWISE_BLOCKS, DwellAttempt
from station.guide.face_and_stillness import BlockLook
from station.stream.live.stillness import Block

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
    one.forget_restless(lambda each: True)
    assert [each.first for each in one.kept][:1] == [SAMPLES]
    assert not one.is_complete


def test_a_dwell_that_began_before_the_cube_stood_begins_again_instead_of_waiting_for_ever() -> None:
    one = dwelling(60)
    said = [one.take(block(i, rate), LOOK) for i, rate in enumerate([*[LOWERED] * 8, *[REST] * 30])]
    assert OTHERWISE in said
    assert said.index(OTHERWISE) == 8 + OTHERWISE_BLOCKS - 1


@pytest.mark.parametrize("disturbed", [1, 4])
def test_a_short_bump_is_no_other_stand(disturbed: int) -> None:
    one = dwelling(60)
    rates = [*[REST] * 10, *[LOWERED] * disturbed, *[REST] * 20]
    assert OTHERWISE not in [one.take(block(i, rate), LOOK) for i, rate in enumerate(rates)]
