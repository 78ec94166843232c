"""One sample of the strapdown integration against the exact motion of a rigid body that turns steadily."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude.kalman_state import AIDED_SETTINGS, KalmanState, new_state
from procedures.attitude.strapdown_integration import integrate_sample

G = 9.80665
DT = 0.01
TURN = np.array([2.5, -4.0, 3.2])  # rad/s


def started(C_nb: FloatArray) -> KalmanState:
    state = new_state(with_air=False)
    state.C_nb[:] = C_nb
    state.memory[0].started = 1.0
    return state


def integrated(state: KalmanState, dt: float, omega_b: FloatArray, f_b: FloatArray) -> None:
    settings = AIDED_SETTINGS._replace(nominal_s=dt, gravity=G)
    integrate_sample(state, settings, dt, omega_b, f_b, math.nan)


def some_attitude(seed: int) -> FloatArray:
    C_nb: FloatArray = Rotation.random(random_state=seed).as_matrix()
    return C_nb


@pytest.mark.parametrize("seed", range(2))
def test_a_body_that_spins_as_it_hovers_gains_no_velocity(seed: int) -> None:
    """Its force is up in the level frame all the time; what it feels is that, turned by the spin.

    With the angle ``a`` turned in a sample the mean force is ``(1 - a/2 + a^2/6) f``, cross products meant: half
    of the turn is taken back, and ``a^2/12`` of the force is left.
    """
    C_nb = some_attitude(seed)
    fine = (np.arange(1000) + 0.5) / 1000 * DT
    on_the_way = Rotation.from_matrix(C_nb) * Rotation.from_rotvec(np.outer(fine, TURN))
    f_b = on_the_way.inv().apply([0.0, 0.0, -G]).mean(axis=0)
    state = started(C_nb)
    integrated(state, DT, TURN, f_b)
    angle = np.linalg.norm(TURN) * DT
    assert np.linalg.norm(state.v_n) < 1.1 * angle**2 / 12 * G * DT
    assert angle**2 / 12 < 0.02 * angle / 2  # what is left beside what half of the turn is worth


@pytest.mark.parametrize("dt", [0.08, 0.2])  # a series below half a radian, here near its end
def test_the_attitude_after_a_steady_turn_is_the_rotation_vectors(dt: float) -> None:
    C_nb = some_attitude(5)
    state = started(C_nb)
    integrated(state, dt, TURN, np.array([0.0, 0.0, -G]))
    expected = C_nb @ Rotation.from_rotvec(TURN * dt).as_matrix()
    assert state.C_nb == pytest.approx(expected, abs=4e-9)  # a^9/9!


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("error", ["gyro_scale", "gyro_bias"])
def test_a_gyros_scale_and_bias_are_taken_off_its_own_axis(axis: int, error: str) -> None:
    """A scale of s means that what is read is too large by s of it."""
    C_nb, size = some_attitude(6), 0.05
    state, off = started(C_nb), np.zeros(3)
    state.slow[0][error][axis] = size
    off[axis] = size * TURN[axis] if error == "gyro_scale" else size
    integrated(state, DT, TURN, np.array([0.0, 0.0, -G]))
    turned = Rotation.from_matrix(C_nb.T @ state.C_nb).as_rotvec()
    assert turned == pytest.approx((TURN - off) * DT, abs=1e-12)


def test_the_earths_rate_in_the_level_frame_is_taken_off_where_the_heading_is_known() -> None:
    C_nb, earth_n = some_attitude(7), np.array([4e-3, 0.0, -6e-3])
    state = started(C_nb)
    state.memory[0].heading_known = 1.0
    settings = AIDED_SETTINGS._replace(nominal_s=DT, earth_north=earth_n[0], earth_down=earth_n[2])
    at_rest = C_nb.T @ earth_n
    integrate_sample(state, settings, DT, at_rest, np.array([0.0, 0.0, -G]), math.nan)
    assert state.C_nb == pytest.approx(C_nb, abs=1e-15)
