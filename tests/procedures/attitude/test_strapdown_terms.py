"""Alignment, one sample and the correction of the Kalman filter, each number against numpy's and scipy's."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.attitude import complementary_kernels
from procedures.attitude.kalman import strapdown_integration as strapdown
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.kalman_state import KalmanState, new_state
from tests.procedures.attitude.uncompiled import uncompiled

C = KalmanSettings(
    gravity=9.7, nominal_s=0.01, tilt_std=0.2, velocity_std=0.9, velocity_std_per_speed=0.11, gyro_bias_std=0.04,
    gyro_scale_std=0.003, force_bias_std=0.06, attack_std=0.07, slip_std=0.02, earth_north=4e-3, earth_down=-6e-3,
)  # fmt: skip
RATE, FORCE = np.array([0.5, -0.7, 0.9]), np.array([1.0, 2.0, -9.0])


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, strapdown, complementary_kernels)


def state(with_air: bool = True) -> KalmanState:
    s = new_state(with_air)
    slow, memory = s.slow[0], s.memory[0]
    s.C_nb[:] = Rotation.from_euler("ZYX", (0.7, 0.3, -0.4)).as_matrix()
    s.v_n[:], s.sums[:] = (4.0, -3.0, 1.5), 0.5
    slow.gyro_bias[:], slow.gyro_scale[:], slow.force_bias[:] = (
        (0.01, -0.02, 0.03),
        (0.1, 0.2, -0.3),
        (0.1, 0.3, -0.2),
    )
    slow.attack, slow.slip = 0.05, -0.03
    memory.velocity_gain[:], memory.rate_integral[:], memory.force_integral[:] = 0.1, 0.2, 0.3
    memory.time, memory.rate_squared, memory.airspeed_sum, memory.airspeed_rows = 0.4, 0.6, 30.0, 2.0
    memory.last_rate[:], memory.heading_known, memory.started = (0.3, 0.1, -0.1), 1.0, 1.0
    return s


def integrated(s: KalmanState, dt: float = 0.01, air: float = math.nan, **changed: float) -> None:
    strapdown.integrate_sample(s, C._replace(**changed), dt, RATE, FORCE, air)  # type: ignore[arg-type]


@pytest.mark.parametrize("knows_north", [True, False])
def test_a_sample_turns_by_its_rate_less_bias_scale_and_earth_and_gains_its_force_half_way(
    knows_north: bool,
) -> None:
    s, before = state(), state()
    s.memory[0].heading_known = float(knows_north)
    integrated(s)
    slow, C_nb = before.slow[0], before.C_nb
    earth = C_nb.T @ (4e-3 * knows_north, 0.0, -6e-3)
    turn = (RATE - slow.gyro_bias - slow.gyro_scale * RATE - earth) * 0.01
    gained = (FORCE - slow.force_bias) * 0.01
    gained = C_nb @ (gained + 0.5 * np.cross(turn, gained))
    np.testing.assert_allclose(s.C_nb, C_nb @ Rotation.from_rotvec(turn).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(s.v_n, before.v_n + gained + [0.0, 0.0, 9.7 * 0.01], atol=1e-14)
    np.testing.assert_allclose(s.memory[0].velocity_gain, 0.1 + gained, atol=1e-14)
    np.testing.assert_allclose(s.sums, 0.5 + np.hstack((C_nb, C_nb * RATE)) * 0.01, atol=1e-14)


def test_a_gap_turns_by_the_mean_of_the_rates_next_to_it_and_is_uncertain() -> None:
    s, edge = state(), state()
    integrated(edge, dt=0.0149)
    assert edge.memory[0].unseen_angle == 0.0
    integrated(s, dt=0.05)
    half = 0.5 * (1 - 0.01 / 0.05)
    rate = RATE + half * ([0.3, 0.1, -0.1] - RATE)
    assert s.memory[0].last_rate == pytest.approx(rate)
    assert s.memory[0].rate_integral == pytest.approx(0.2 + rate * 0.05)
    assert s.memory[0].rate_squared == pytest.approx(0.6 + rate @ rate * 0.05)
    assert s.memory[0].unseen_angle == pytest.approx((0.2 + 0.5 * math.sqrt(1.55)) * 0.04)
    assert s.memory[0].unseen_velocity == pytest.approx(2.0 * 0.04)


@pytest.mark.parametrize("air", [math.nan, 20.0, -20.0])
@pytest.mark.parametrize("with_air", [True, False])
def test_alignment_begins_level_velocity_and_biases_as_they_are_stated(air: float, with_air: bool) -> None:
    s, force = state(with_air), np.array([-3.0, 2.0, -8.0])
    s.memory[0].started, s.P[:] = 0.0, 0.0
    s.P[0, 8] = s.P[8, 0] = s.P[5, 9] = 1.0
    strapdown.align(s, C, force, air)
    down = -force / np.linalg.norm(force)
    north = np.array([1.0, 0.0, 0.0]) - down[0] * down
    north /= np.linalg.norm(north)
    np.testing.assert_allclose(s.C_nb, [north, np.cross(down, north), down], atol=1e-14)
    has_air = not math.isnan(air)
    np.testing.assert_allclose(s.v_n, s.C_nb[:, 0] * air if has_air else np.zeros(3))
    v_std = 0.9 + 0.11 * 20.0 * has_air
    stds = [0.2, 0.2, 0.0, *[v_std] * 3, *[0.04] * 3, *[0.003] * 3, *[0.06] * 3, *[0.07, 0.02] * with_air]
    np.testing.assert_allclose(s.P, np.diag(np.square(stds)), atol=1e-15)
    memory = s.memory[0]
    assert (memory.started, memory.velocity_known) == (1.0, float(has_air))
    assert math.isnan(memory.speed)
    assert memory.time == memory.heading_known == 0.0
    assert not s.sums.any()
    assert not s.past.any()


def test_a_correction_is_taken_off_all_that_the_filter_knows() -> None:
    s, before = state(), state()
    s.dx[:] = np.linspace(0.01, 0.17, 17)
    strapdown.apply_correction(s)
    np.testing.assert_allclose(s.C_nb, Rotation.from_rotvec(-s.dx[:3]).as_matrix() @ before.C_nb, atol=1e-11)
    slow, old = s.slow[0], before.slow[0]
    np.testing.assert_allclose(s.v_n, before.v_n - s.dx[3:6])
    np.testing.assert_allclose(slow.gyro_bias, old.gyro_bias - s.dx[6:9])
    np.testing.assert_allclose(slow.gyro_scale, old.gyro_scale - s.dx[9:12])
    np.testing.assert_allclose(slow.force_bias, old.force_bias - s.dx[12:15])
    assert (slow.attack, slow.slip) == pytest.approx((0.05 - 0.16, -0.03 - 0.17))
