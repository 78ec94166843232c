"""Whether a wheel is believed at a keyframe: its sign, what is foretold, slips and rests, by hand."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.inner.wheel_aid import CREEP_SIGMAS, SLIP_SIGMAS, WheelAid
from procedures.fusion.wheel_speeds import KeyframeWheel, WheelMount, WheelSpeeds
from tests.procedures.fusion.motions import NOISE

FORWARD, CERTAIN = np.array([0.6, 0.8, 0.0]), np.zeros((4, 4))
NO_IMU = ImuSeries(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)))


def aid(is_signed: bool = False) -> WheelAid:
    mount = WheelMount(FORWARD, np.zeros(3), 0.05, 0.02, is_signed)
    return WheelAid(mount, WheelSpeeds(np.zeros(0), np.zeros(0)), NOISE)


def wheel(speed: float) -> KeyframeWheel:
    return KeyframeWheel(FORWARD, 0.1, speed, 400.0)  # its sigma is 0.05 m/s


def judged(
    one: WheelAid, speed: float, along: float, t: float = 1.0, P: FloatArray = CERTAIN, scale: float = 0.98
) -> KeyframeWheel:
    return one.judged(wheel(speed), t, 0.1, along * FORWARD, scale, P, NO_IMU)


def test_a_wheel_without_a_sign_has_that_of_what_is_foretold() -> None:
    for along, speed in ((5.0, 5.0), (-4.8, -5.0)):  # the wheel tells 4.9 m/s, the turn makes 0.1 of it
        found = judged(aid(), 5.0, along)
        assert found.speed == speed
        assert found.weight == 400.0


def test_a_wheel_with_a_sign_keeps_it_and_is_not_believed_the_wrong_way() -> None:
    one = aid(is_signed=True)
    found = judged(one, 5.0, -4.8)
    assert (found.speed, found.weight) == (5.0, 0.0)
    assert one.slips_now
    assert judged(aid(is_signed=True), -5.0, -4.8).weight == 400.0


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_slip_is_what_chance_does_not_do(sign: int) -> None:
    for sigmas, slips in ((SLIP_SIGMAS - 0.05, False), (SLIP_SIGMAS + 0.05, True)):
        one = aid(is_signed=True)
        off = sign * sigmas * 0.05
        found = judged(one, 5.0, 0.98 * 5.0 + 0.1 - off)
        assert one.slips_now == (slips or sigmas > CREEP_SIGMAS)
        assert found.weight == (0.0 if one.slips_now else 400.0)
