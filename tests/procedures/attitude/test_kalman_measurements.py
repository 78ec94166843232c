"""Each measurement of the Kalman filter: one step against the textbook's, its slopes by differences."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude.kalman import kalman_measurements as kalman
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.kalman_state import KalmanState, new_state
from tests.procedures.attitude.uncompiled import uncompiled

Says = Callable[[FloatArray], float]  # what the state says, of the errors (n,) it has
SETTINGS = KalmanSettings(
    airspeed_noise=0.8, gust_noise=1.3, climb_noise=7.0, climb_noise_per_speed=0.3, velocity_std=0.9,
    velocity_std_per_speed=0.11, tilt_std=0.2, gyro_bias_std=0.04, rest_speed=1.5, heading_std=0.07,
    rest_velocity_noise=0.013, rest_rate_noise=3e-4, gyro_noise=2e-4, earth_north=4e-5, earth_down=-6e-5,
    believed_sigma=1e9,
)  # fmt: skip


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, kalman)


def state(with_air: bool = True, seed: int = 1) -> KalmanState:
    """Return a state as it is found in flight: no number is nought, none stands twice."""
    rng = np.random.default_rng(seed)
    s = new_state(with_air)
    root = rng.normal(0, 0.1, (len(s.dx), len(s.dx)))
    s.C_nb[:] = Rotation.from_euler("ZYX", (0.7, 0.3, -0.4)).as_matrix()
    s.v_n[:] = 21.0, -13.0, 2.5
    s.P[:], s.dx[:] = root @ root.T, rng.normal(0, 0.01, len(s.dx))
    s.past[:] = rng.normal(size=s.past.shape)
    slow, memory = s.slow[0], s.memory[0]
    slow.gyro_bias[:], slow.gyro_scale[:] = (0.01, -0.02, 0.03), (1e-3, 2e-3, -3e-3)
    slow.attack, slow.slip = 0.05, -0.03
    memory.time, memory.airspeed_sum, memory.airspeed_rows = 0.04, 96.0, 4.0
    memory.velocity_known = memory.heading_known = 1.0
    return s


def slopes(s: KalmanState, says: Says) -> FloatArray:
    step = 1e-6
    unit = np.eye(len(s.dx)) * step
    return np.array([(says(x) - says(-x)) / (2 * step) for x in unit])


def taken(
    P: FloatArray, dx: FloatArray, H: FloatArray, error: float, variance: float
) -> tuple[FloatArray, FloatArray]:
    """Return covariance and correction after a scalar measurement: Kalman, 1960."""
    gain = P @ H / (H @ P @ H + variance)
    return P - np.outer(gain, H @ P), dx + gain * (error - H @ dx)


def assert_taken(s: KalmanState, before: KalmanState, *measured: tuple[Says, float]) -> None:
    P, dx = before.P, before.dx
    for says, variance in measured:
        P, dx = taken(P, dx, slopes(before, says), says(np.zeros(len(dx))), variance)
    np.testing.assert_allclose(s.P, P, atol=1e-9)
    np.testing.assert_allclose(s.dx, dx, atol=1e-9)


def attitude(s: KalmanState, x: FloatArray) -> FloatArray:
    """Return the rotation of a state with errors x: a small turn of the level frame, from the left."""
    return np.asarray(Rotation.from_rotvec(x[:3]).as_matrix() @ s.C_nb)


def in_body(s: KalmanState, x: FloatArray, axis: int) -> float:
    return float(attitude(s, x)[:, axis] @ (s.v_n + x[3:6]))


@pytest.mark.parametrize("i", range(3))
def test_a_level_velocity_is_a_component_of_the_state(i: int) -> None:
    s = state()
    kalman.measure_level_velocity(s, SETTINGS, i, 5.0, 0.3)
    before = state()
    assert_taken(s, before, (lambda x: before.v_n[i] + x[3 + i] - 5.0, 0.3))


def test_airspeed_is_the_velocity_along_x_and_the_air_comes_from_attack_and_slip() -> None:
    s, before = state(), state()
    kalman.measure_airspeed(s, SETTINGS)
    speed, T = 24.0, 0.04  # 96 m/s in four rows
    slow = before.slow[0]
    assert_taken(
        s, before,
        (lambda x: in_body(before, x, 0) - speed, 0.8**2 / T),
        (lambda x: in_body(before, x, 1) - speed * (slow.slip + x[16]), 1.3**2 / T),
        (lambda x: in_body(before, x, 2) - speed * (slow.attack + x[15]), 1.3**2 / T),
        (lambda x: before.v_n[2] + x[5], (7.0 + 0.3 * speed) ** 2 / T),
    )  # fmt: skip


@pytest.mark.parametrize(("total", "is_reset"), [(-96.0, True), (6.0, False)])
def test_the_first_airspeed_begins_the_velocity_and_in_motion_the_covariance(total: float, is_reset: bool) -> None:
    s, before = state(), state()
    s.memory[0].velocity_known, s.memory[0].airspeed_sum = 0.0, total
    kalman.measure_airspeed(s, SETTINGS)
    speed = total / 4
    np.testing.assert_allclose(s.v_n, before.C_nb[:, 0] * speed, rtol=1e-12)
    assert s.memory[0].velocity_known == 1.0
    std = 0.9 + 0.11 * abs(speed)
    P = before.P.copy()
    left = [0, 1, 3, 4, 5, 6, 7, 8] if is_reset else [3, 4, 5]
    P[left, :] = P[:, left] = 0.0
    P[left, left] = [0.04, 0.04, std**2, std**2, std**2, 0.0016, 0.0016, 0.0016] if is_reset else [std**2] * 3
    np.testing.assert_allclose(s.P, P, rtol=1e-12)
    assert (s.slow[0].gyro_bias == (0.0 if is_reset else before.slow[0].gyro_bias)).all()


def test_a_turn_of_the_level_frame_turns_all_that_is_written_in_it() -> None:
    s, before = state(), state()
    kalman.turn_level_frame(s, 0.6, 0.05)
    turn = Rotation.from_euler("z", 0.6).as_matrix()
    whole = np.eye(17)
    whole[:3, :3] = whole[3:6, 3:6] = turn
    P = whole @ before.P @ whole.T
    P[2, :] = P[:, 2] = 0.0
    P[2, 2] = 0.05**2
    np.testing.assert_allclose(s.P, P, atol=1e-12)
    np.testing.assert_allclose(s.C_nb, turn @ before.C_nb, atol=1e-12)
    np.testing.assert_allclose(s.v_n, turn @ before.v_n, atol=1e-12)
    past = before.past.copy()
    past[:, 1:4] = past[:, 1:4] @ turn.T
    np.testing.assert_allclose(s.past, past, atol=1e-12)
    assert s.memory[0].heading_known == 1.0


def heading(C: FloatArray) -> float:
    return float(np.arctan2(C[1, 0], C[0, 0]))


@pytest.mark.parametrize("turns", [-1, 0, 1])
def test_a_heading_is_of_body_x_from_north_to_east_and_within_half_a_turn(turns: int) -> None:
    s, before = state(), state()
    assert kalman.heading_of(s) == pytest.approx(0.7)
    kalman.measure_heading(s, SETTINGS, 0.6 + turns * 2 * np.pi)
    assert_taken(s, before, (lambda x: heading(attitude(before, x)) - 0.6, 0.07**2))


def test_headings_on_both_sides_of_south_are_near_each_other() -> None:
    s, before = state(), state()
    for each in (s, before):
        each.C_nb[:] = Rotation.from_euler("ZYX", (3.1, 0.3, -0.4)).as_matrix()
    kalman.measure_heading(s, SETTINGS, -3.1)
    off = 6.2 - 2 * np.pi
    assert_taken(s, before, (lambda x: heading(attitude(before, x)) - 3.1 + off, 0.07**2))


def test_the_first_heading_turns_the_frame_and_an_upright_body_has_none() -> None:
    s, before = state(), state()
    s.memory[0].heading_known = 0.0
    kalman.measure_heading(s, SETTINGS, -1.2)
    assert kalman.heading_of(s) == pytest.approx(-1.2)
    assert s.P[2, 2] == pytest.approx(0.07**2)
    s = state()
    for pitch, says in ((1.3, True), (1.38, False), (-1.38, False)):  # the sine is 0.9636 and 0.9819
        s.C_nb[:] = Rotation.from_euler("ZYX", (0.7, pitch, 0.1)).as_matrix()
        s.P[:] = before.P
        kalman.measure_heading(s, SETTINGS, 0.6)
        assert (s.P != before.P).any() == says


def resting(s: KalmanState, c: KalmanSettings, aided: bool, still_time: float = 2.0) -> bool:
    """Whether 0.04 s more are rest: too short for a span, so that the last word stands."""
    memory = s.memory[0]
    memory.still_time = still_time
    memory.rate_integral[:] = np.multiply((0.011, -0.021, 0.032), memory.time)
    memory.force_integral[:] = np.multiply((0.1, 0.2, -9.8), memory.time)
    return bool(kalman.measure_rest(s, c, aided))


def rates_of_earth(s: KalmanState, knows_north: bool) -> FloatArray:
    return s.C_nb.T @ (4e-5 * knows_north, 0.0, -6e-5)


@pytest.mark.parametrize(
    ("aided", "cruise", "knows_north"), [(True, 0.0, True), (True, 0.0, False), (False, 2.0, True)]
)
def test_at_rest_a_gyro_reads_its_bias_its_scale_and_the_earth(
    aided: bool, cruise: float, knows_north: bool
) -> None:
    s, before = state(), state()
    for each in (s, before):
        memory = each.memory[0]
        memory.airspeed_rows, memory.speed, memory.heading_known = 0.0, 0.0, float(knows_north)
        memory.at_rest = 1.0
    assert resting(s, SETTINGS._replace(cruise_std=cruise), aided)
    T, slow = 0.04, before.slow[0]
    kalman.measure_rest_velocity(before, SETTINGS, 0.013**2 / T)
    earth, rate = rates_of_earth(before, knows_north), (0.011, -0.021, 0.032)

    def reads(i: int) -> Says:
        return lambda x: (
            slow.gyro_bias[i] + x[6 + i] + (slow.gyro_scale[i] + x[9 + i]) * rate[i] + earth[i] - rate[i]
        )

    variance = (3e-4**2 + 2e-4**2) / T
    assert_taken(s, before, *[(reads(i), variance) for i in range(3)])
