"""Whether a wheel is believed at a keyframe: its sign, what is foretold, slips and rests, by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.imu.gnss_velocity import no_fix
from procedures.fusion.inner.wheel_aid import CREEP_SIGMAS, SLIP_SIGMAS, WheelAid, without_wheel
from procedures.fusion.inner.window_problem import Held
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


def test_what_is_foretold_badly_is_no_slip() -> None:
    """A velocity along the wheel known to 0.3 m/s, and a scale factor to a tenth at 5 m/s."""
    P = np.diag([0.0, 0.0, 0.0, 0.01])
    P[:3, :3] = 0.09 * np.outer(FORWARD, FORWARD)
    sigma = np.sqrt(0.09 + 25 * 0.01 + 0.0025)
    least = min(SLIP_SIGMAS, CREEP_SIGMAS)
    for sigmas in (least - 0.05, least + 0.05):
        one = aid(is_signed=True)
        judged(one, 5.0, 0.98 * 5.0 + 0.1 - sigmas * sigma, P=P)
        assert one.slips_now == (sigmas > least)


def test_a_speed_of_nought_may_be_one_that_the_sensor_does_not_feel() -> None:
    found = judged(aid(is_signed=True), 0.0, 0.1)
    assert found.weight == pytest.approx(1 / (1 / 400.0 + 0.25))


def test_what_a_wheel_said_in_the_last_seconds_goes_and_what_it_said_before_stays() -> None:
    """Keyframes 1, 2 and 4 s apart, the last 0.5 s ago, so that they are 7.5, 6.5, 4.5 and 0.5 s old."""
    parts = [SimpleNamespace(dt=seconds) for seconds in (1.0, 2.0, 4.0)]
    held = Held(parts, [replace(no_fix(), wheel=wheel(float(i))) for i in range(4)])  # type: ignore[arg-type]
    left = without_wheel(held, 0.5, 5.0)
    assert [fix.wheel and fix.wheel.speed for fix in left.fixes] == [0.0, 1.0, None, None]
    assert left.parts == parts
    assert [fix.wheel is None for fix in without_wheel(held, 0.5, 6.6).fixes] == [False, True, True, True]
    assert not any(fix.wheel is None for fix in without_wheel(held, 0.5, 0.5).fixes)  # not younger than that
