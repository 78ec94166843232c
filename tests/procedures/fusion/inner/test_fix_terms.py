"""The residuals of a fix with unknown lever arm and time offset: slopes as differences have."""

import numpy as np

from procedures.frames import rotation
from procedures.fusion.imu.gnss_velocity import KeyframeFix
from procedures.fusion.inner.fix_terms import add_fixes, fix_residuals
from procedures.fusion.inner.window_state import ANTENNA, COMMON, FRAME, HEADING, WindowState, zero

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


def test_a_velocity_alone_says_of_the_antenna_what_its_swing_shows() -> None:
    rng = np.random.default_rng(2)
    state, none = two_keyframes(rng), np.zeros(3)
    swing = np.outer([1.0, 0.0, 0.0], [0.0, 0.5, 0.0])
    normal = zero(state.size)
    add_fixes(normal, state, [KeyframeFix(none, np.full(3, 4.0), none, none, 0.0, none, swing, none)])
    assert np.allclose(normal.A[ANTENNA, ANTENNA], np.diag([0.0, 1.0, 0.0, 0.0]))
