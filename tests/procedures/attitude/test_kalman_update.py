"""The Kalman filter's covariance and its fixes of GNSS against the textbook's matrices, term by term."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude.kalman import kalman_filter, kalman_state
from procedures.attitude.kalman import kalman_measurements as gnss
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.kalman_state import KalmanState, new_state
from tests.procedures.attitude.uncompiled import uncompiled

C = KalmanSettings(
    gravity=9.7, gyro_noise=3e-3, gyro_noise_per_rate=0.02, gyro_bias_walk=4e-3, force_noise=0.2,
    force_bias_walk=5e-3, attack_std=0.3, attack_s=0.7, slip_std=0.2, slip_s=0.4, rest_gyro_noise=1e-3,
    rest_force_noise=0.03, rest_bias_walk=2e-3, unseen_rate=0.05, believed_sigma=3.0, velocity_fix_std=0.3,
    course_std=0.26, course_speed=3.0, rest_speed=1.0, fix_latency=0.25, update_s=0.05,
)  # fmt: skip


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, kalman_state, gnss, kalman_filter)


def state(n: int = 17) -> KalmanState:
    rng = np.random.default_rng(3)
    s = new_state(n == 17)
    root = rng.normal(0, 0.3, (n, n))
    s.P[:], s.sums[:] = root @ root.T, rng.normal(0, 0.2, (3, 6))
    s.C_nb[:] = Rotation.from_euler("ZYX", (0.7, 0.3, -0.4)).as_matrix()
    s.v_n[:] = 4.0, -3.0, 1.5
    memory = s.memory[0]
    memory.velocity_gain[:] = 0.7, -1.1, -4.9
    memory.rate_integral[:] = 0.2, -0.3, 0.6  # a turn of 0.7 rad
    memory.time, memory.rate_squared, memory.unseen_angle, memory.unseen_velocity = 0.5, 1.7, 0.03, 0.4
    memory.velocity_known, memory.speed = 1.0, 5.0
    s.slow[0].attack, s.slow[0].slip = 0.05, -0.03
    return s


@pytest.mark.parametrize("n", [15, 17])
@pytest.mark.parametrize("at_rest", [False, True])
def test_the_covariance_goes_on_by_its_transition_and_by_what_went_on_unseen(n: int, at_rest: bool) -> None:
    s, before = state(n), state(n)
    s.memory[0].at_rest = float(at_rest)
    kalman_state.propagate(s, C)
    F, gain, T = np.eye(n), np.array([0.7, -1.1, -4.9]), 0.5
    if at_rest:
        gain[:2] = 0.0
    F[:3, 6:12] = -before.sums  # psi' = -C (b + scale * rate)
    F[3:6, :3] = np.cross(np.eye(3), gain).T  # v' = psi x f_n - C b_f
    F[3:6, 12:15] = -before.sums[:, :3]
    gyro, force, walk = (1e-3, 0.03, 2e-3) if at_rest else (3e-3, 0.2, 4e-3)
    Q = np.zeros(n)
    Q[:3] = gyro**2 * T + 0.02**2 * 1.7 + 0.03**2
    Q[3:6] = force**2 * T + 0.4**2
    Q[6:9] = walk**2 * T + 0.05**2 * 0.7
    Q[12:15] = 5e-3**2 * T
    if n == 17:
        left = np.exp([-0.5 / 0.7, -0.5 / 0.4])
        F[15:, 15:], Q[15:] = np.diag(left), np.square((0.3, 0.2)) * (1 - left**2)
        assert [s.slow[0].attack, s.slow[0].slip] == pytest.approx([0.05 * left[0], -0.03 * left[1]])
    np.testing.assert_allclose(s.P, F @ before.P @ F.T + np.diag(Q), atol=1e-12)


@pytest.mark.parametrize("error", [0.4, -9.0])
def test_a_measurement_is_kalmans_and_beyond_three_sigma_counts_as_if_it_stood_there(error: float) -> None:
    s, P = state(), state().P
    s.dx[:] = np.linspace(-0.1, 0.2, 17)
    before, H = s.dx.copy(), np.zeros(17)
    s.at[:3], s.H[:3] = (2, 5, 11), (0.7, -1.2, 0.4)
    H[[2, 5, 11]] = 0.7, -1.2, 0.4
    s.PH[:] = 1e3
    kalman_state.measure(s, 3, error, 0.01, 3.0)
    left = error - H @ before
    size = max(H @ P @ H + 0.01, (left / 3) ** 2)
    assert (size > H @ P @ H + 0.01) == (abs(error) > 1)
    np.testing.assert_allclose(s.dx, before + P @ H * left / size, atol=1e-12)
    np.testing.assert_allclose(s.P, P - np.outer(P @ H, H @ P) / size, atol=1e-12)


def ring(s: KalmanState) -> FloatArray:
    """Fill the ring: the newest in place 1, before it 0, 63, 62 ..., of 0.1, 0.2, 0.3 ... s."""
    s.memory[0].newest = 1.0
    for age in range(8):
        s.past[1 - age] = 0.1 * (age + 1), 1.0 + age, 10.0 + age, 20.0 + age, 30.0 + age
    return s.past.copy()


SINCE = np.array([0.25, 1.0 + 0.75 * 2, 10.0 + 0.75 * 11, 20.0 + 0.75 * 21, 30.0 + 0.75 * 31])  # 0.25 s of it


def test_a_fix_is_of_the_velocity_at_its_own_moment() -> None:
    s, before, vel = state(), state(), (4.2, -2.8, 1.4)
    for each in (s, before):
        ring(each)
        each.memory[0].heading_known = 1.0
    settings = C._replace(believed_sigma=1e9)
    gnss.measure_gnss_velocity(s, settings, np.array(vel))
    assert s.memory[0].speed == pytest.approx(np.hypot(4.2, -2.8))
    force = SINCE[1:4] - [0.0, 0.0, 9.7 * 0.25]  # what the specific force gained: less the weight
    P, dx = before.P, before.dx
    for i in range(3):
        H = np.zeros(17)
        H[:3] = -np.cross(np.eye(3), force)[:, i]
        H[3 + i] = 1.0
        gain = P @ H / (H @ P @ H + 0.3**2)
        P, dx = P - np.outer(gain, H @ P), dx + gain * (before.v_n[i] - SINCE[1 + i] - vel[i] - H @ dx)
    np.testing.assert_allclose(s.P, P, atol=1e-9)
    np.testing.assert_allclose(s.dx, dx, atol=1e-9)


def test_the_first_course_that_is_fast_enough_is_the_heading_and_the_velocity() -> None:
    s, before = state(), state()
    ring(s)
    gnss.measure_gnss_velocity(s, C, np.array((-4.0, 3.0, 0.5)))
    heading = np.arctan2(s.C_nb[1, 0], s.C_nb[0, 0])
    assert np.cos(heading - (np.arctan2(3.0, -4.0) + SINCE[4])) == pytest.approx(1.0)
    assert s.memory[0].heading_known == 1.0
    np.testing.assert_allclose(s.C_nb[2], before.C_nb[2])
    turn = Rotation.from_euler("z", heading - 0.7).as_matrix()
    assert s.v_n == pytest.approx(np.array([-4.0, 3.0, 0.5]) + turn @ SINCE[1:4])
    assert np.diag(s.P)[2:6] == pytest.approx([0.26**2] + [0.6**2] * 3)
