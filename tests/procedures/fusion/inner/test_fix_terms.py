"""The residuals of a fix with unknown lever arm and time offset: slopes as differences have."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.frames import rotation, skew
from procedures.fusion.gnss_velocity import KeyframeFix
from procedures.fusion.inner.window_state import COMMON, FRAME, HEADING, WindowState
from procedures.fusion.inner.window_terms import fix_residuals

STEP = 1e-6


def two_keyframes(rng: np.random.Generator) -> WindowState:
    p, v, bg, ba = rng.normal(size=(4, 2, 3))
    C_ob = rotation(rng.normal(size=(2, 3)))
    return WindowState(
        C_ob, p, v, bg, ba, np.eye(3), np.zeros(3), 0.3, np.zeros((0, 3)), antenna=rng.normal(size=4)
    )


def test_slopes_are_those_of_differences() -> None:
    rng = np.random.default_rng(1)
    state = two_keyframes(rng)
    v, p, lever, a = rng.normal(size=(4, 3))
    fix = KeyframeFix(v, np.ones(3), p, np.ones(3), -0.05, lever, rng.normal(size=(3, 3)), a)
    r, J, _ = fix_residuals(state, [1], [fix])
    columns = []
    for k in [*range(HEADING, COMMON), *range(COMMON + FRAME, COMMON + 2 * FRAME)]:
        step = np.zeros(state.size)
        step[k] = STEP
        columns.append((fix_residuals(state.moved(step), [1], [fix])[0][0] - r[0]) / STEP)
    assert np.allclose(J[0], np.array(columns).T, atol=1e-5)


def test_a_fix_of_the_true_antenna_leaves_no_residual() -> None:
    """A body flies straight and spins; its antenna is seen from a frame whose heading is not the window's.

    Where the antenna is and how fast are taken from its path, by differences in time, not from the terms.
    """
    rng = np.random.default_rng(3)
    state = two_keyframes(rng)
    k, omega_b, age = 1, rng.normal(size=3), -0.05
    lever, more, tau = rng.normal(size=3), state.antenna[:3], state.antenna[3]
    cosine, sine = np.cos(state.heading), np.sin(state.heading)
    C_no = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def antenna_n(turned: float, moved: float) -> FloatArray:
        in_o = state.p[k] + state.v[k] * moved + state.C_ob[k] @ rotation(omega_b * turned) @ (lever + more)
        seen: FloatArray = C_no @ in_o
        return seen

    v_n = (antenna_n(STEP, STEP) - antenna_n(-STEP, -STEP)) / (2 * STEP)
    p_n = antenna_n(0.0, age + tau)
    fix = KeyframeFix(v_n, np.ones(3), p_n, np.ones(3), age, lever, skew(omega_b), np.zeros(3))
    r, _, _ = fix_residuals(state, [k], [fix])
    assert r[0] == pytest.approx(np.zeros(6), abs=1e-8)


def test_a_velocity_stamped_late_is_that_of_an_acceleration_before() -> None:
    state = two_keyframes(np.random.default_rng(4))
    a_n, none = np.array([1.0, -2.0, 0.5]), np.zeros(3)
    now = KeyframeFix(none, np.ones(3), none, none, 0.0, none, np.zeros((3, 3)), none)
    later = KeyframeFix(none, np.ones(3), none, none, 0.0, none, np.zeros((3, 3)), a_n)
    without, with_it = (fix_residuals(state, [0], [fix])[0][0, :3] for fix in (now, later))
    assert with_it - without == pytest.approx(a_n * state.antenna[3])
