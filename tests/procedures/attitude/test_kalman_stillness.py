"""What the Kalman filter takes for rest: rates and forces that stand still over a span, hand-made."""

import numpy as np
import pytest

from procedures.attitude import kalman_measurements as kalman
from procedures.attitude.kalman_state import KalmanSettings, KalmanState, new_state
from tests.procedures.attitude.uncompiled import uncompiled


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, kalman)


def still(s: KalmanState, c: KalmanSettings, rate: tuple[float, ...], force: tuple[float, ...], T: float) -> float:
    memory = s.memory[0]
    memory.time, memory.rate_integral, memory.force_integral = T, np.multiply(rate, T), np.multiply(force, T)
    kalman.judge_stillness(s, c)
    return float(memory.still_time)


RESTING = KalmanSettings(update_s=0.1, gravity=10.0, rest_rate=0.02, rest_force=0.3)


def at_rest() -> KalmanState:
    s = new_state(False)
    memory = s.memory[0]
    memory.mean_rate[:], memory.mean_force[:] = (0.01, 0.0, -0.01), (0.0, 0.0, -10.0)
    s.slow[0].gyro_bias[:] = 0.01, 0.0, -0.01
    s.P[6:9, 6:9] = np.diag([1e-4, 1e-4, 1e-4])  # 3 sigma are 0.03 rad/s
    return s


@pytest.mark.parametrize(
    ("rate", "force", "is_still"),
    [
        ((0.01, 0.0, 0.009), (0.0, 0.0, -10.0), True),  # 0.019 of 0.02 rad/s off the mean
        ((0.01, 0.0, 0.011), (0.0, 0.0, -10.0), False),
        ((0.0235, 0.0, 0.0035), (0.0, 0.0, -10.0), True),  # 0.0191, of two axes
        ((0.0255, 0.0, 0.0055), (0.0, 0.0, -10.0), False),  # 0.0219
        ((0.01, 0.0, -0.01), (0.0, 0.28, -10.0), True),
        ((0.01, 0.0, -0.01), (0.0, 0.32, -10.0), False),
        ((0.01, 0.0, -0.01), (0.2, 0.2, -10.0), True),
        ((0.01, 0.0, -0.01), (0.22, 0.22, -10.0), False),
        ((0.01, 0.0, -0.01), (0.2, 0.1, -10.2), True),
    ],
)
def test_what_varies_by_more_than_rest_may_is_none(
    rate: tuple[float, ...], force: tuple[float, ...], is_still: bool
) -> None:
    assert (still(at_rest(), RESTING, rate, force, 0.1) > 0.0) == is_still


@pytest.mark.parametrize(("norm", "is_still"), [(10.45, True), (10.55, False), (9.55, True), (9.45, False)])
def test_at_rest_the_force_is_gravity_to_a_twentieth(norm: float, is_still: bool) -> None:
    s = at_rest()
    force = (0.0, 0.6 * norm, -0.8 * norm)
    s.memory[0].mean_force[:] = force
    assert (still(s, RESTING, (0.01, 0.0, -0.01), force, 0.1) > 0.0) == is_still


@pytest.mark.parametrize(("rate", "is_still"), [(0.048, True), (0.052, False), (-0.048, True), (-0.052, False)])
def test_a_steady_turn_beyond_three_sigma_of_the_bias_is_no_rest(rate: float, is_still: bool) -> None:
    s = at_rest()
    s.memory[0].mean_rate[1] = rate  # 0.02 and 3 times 0.01 rad/s are allowed
    assert (still(s, RESTING, (0.01, rate, -0.01), (0.0, 0.0, -10.0), 0.1) > 0.0) == is_still
