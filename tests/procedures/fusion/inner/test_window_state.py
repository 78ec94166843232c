"""The vector of an inner window: what is moved by a step is that step from where it was."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.inner.window_state import COMMON, FRAME, HEADING, OFFSET, WHEEL, WindowState

FRAMES, HELD = 3, 2


@pytest.fixture
def state() -> WindowState:
    def drawn(*shape: int) -> FloatArray:
        return rng.standard_normal(shape)

    rng = np.random.default_rng(5)
    p, v, bg, ba, rate = drawn(5, FRAMES, 3)
    return WindowState(
        rotation(drawn(FRAMES, 3)), p, v, bg, ba, rotation(drawn(3)), drawn(3), 0.7, drawn(HELD, 3), 0.03, rate,
        drawn(4), 0.02, 0.011,
    )  # fmt: skip


def test_what_is_moved_by_a_step_is_that_step_from_where_it_was(state: WindowState) -> None:
    step = 0.1 * np.random.default_rng(6).standard_normal(state.size)
    assert state.size == COMMON + FRAMES * FRAME + 3 * HELD
    moved = state.moved(step)
    assert moved.less(state) == pytest.approx(step, abs=1e-12)
    assert moved.heading - state.heading == pytest.approx(step[HEADING])
    assert moved.offset - state.offset == pytest.approx(step[OFFSET])
    assert moved.wheel - state.wheel == pytest.approx(step[WHEEL])


def test_a_frame_was_taken_later_by_the_offset_and_a_sight_by_its_line_as_well(state: WindowState) -> None:
    assert state.rate is not None
    C, p = state.exposed()
    assert p == pytest.approx(state.p + 0.03 * state.v)
    assert C[1] == pytest.approx(state.C_ob[1] @ rotation(0.03 * state.rate[1]))
    C, p = state.seen_from(np.array([2, 0]), np.array([-0.5, 0.4]))
    assert p == pytest.approx(state.p[[2, 0]] + np.array([[0.03 - 0.0055], [0.03 + 0.0044]]) * state.v[[2, 0]])
    assert C[1] == pytest.approx(state.C_ob[0] @ rotation(0.0344 * state.rate[0]))
