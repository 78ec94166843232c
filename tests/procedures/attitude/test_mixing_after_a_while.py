import numpy as np
import pytest
from scipy.signal import lsim

from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.complementary_gains import PAPER_GAINS
from procedures.attitude.forward_right_down import down_of, roll_pitch_of

G = 9.80665


def test_a_minute_after_its_start_the_law_with_airspeed_answers_by_its_own_gain() -> None:
    """Not by that of its first seconds, a running mean: a step of roll as the accelerometers have it."""
    dt, n, at, step = 0.01, 9000, 6000, 0.01
    force = np.tile([0.0, 0.0, -G], (n, 1))
    force[at:] = -G * down_of(np.array(step), np.array(0.0))
    log = AttitudeLog(np.arange(n) * dt, np.zeros((n, 3)), force, np.zeros(n))
    roll = roll_pitch_of(ComplementaryFilter(aid="airspeed", gains=PAPER_GAINS).run(log))[0][at:]
    k1, k2 = PAPER_GAINS.k1, PAPER_GAINS.k2
    t = dt * np.arange(1.0, n - at + 1)
    expected = lsim(([k1, k1 * k2], [1, k1, k1 * k2]), np.full(len(t), step), t)[1]
    assert roll == pytest.approx(expected, abs=0.02 * step)
