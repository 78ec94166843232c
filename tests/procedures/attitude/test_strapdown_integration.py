"""One sample of the strapdown integration against the exact motion of a rigid body that turns steadily."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude.kalman.kalman_settings import AIDED_SETTINGS
from procedures.attitude.kalman.kalman_state import KalmanState, new_state
from procedures.attitude.kalman.strapdown_integration import integrate_sample

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
    assert angle**2 / 12 < 0.02 * angle / 2  # what is left compared with what half of the turn is worth


@pytest.mark.parametrize("dt", [0.08, 0.2])  # a series below half a radian, here near its end
def test_the_attitude_after_a_steady_turn_is_the_rotation_vectors(dt: float) -> None:
    C_nb = some_attitude(5)
    state = started(C_nb)
    integrated(state, dt, TURN, np.array([0.0, 0.0, -G]))
    expected = C_nb @ Rotation.from_rotvec(TURN * dt).as_matrix()
    assert state.C_nb == pytest.approx(expected, abs=4e-9)  # a^9/9!
