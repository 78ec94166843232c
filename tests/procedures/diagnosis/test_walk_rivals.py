"""What goes by time shows in its own triad; a cube that tilts shows in the accelerometers."""

import numpy as np
import pytest

from procedures.diagnosis.walk_rivals import BY_TIME, steps_of_a_walk, triad_of
from procedures.effects import EFFECTS
from tests.procedures.diagnosis.redrawn import seen_by, small


def test_what_goes_by_time_shows_in_its_own_triad_and_a_tilt_in_the_accelerometers() -> None:
    shown = {each.name: triad_of(each) for each in EFFECTS if each.name.endswith(BY_TIME)}
    assert shown["gyroscope.bias_drift"] == shown["gyroscope.jump"] == "gyroscope"
    assert shown["accelerometer.bias_settling"] == shown["placement.tilt"] == "accelerometer"
    assert all(triad == name.partition(".")[0] or name == "placement.tilt" for name, triad in shown.items())


@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_a_unit_of_a_walk_is_a_hundredth_of_a_sigma_of_the_row_it_moves_most(triad: str) -> None:
    _, evidence, _ = seen_by("plain")
    H = steps_of_a_walk(evidence, triad)
    assert H.shape[1] > 3
    assert np.max(np.abs(H) / evidence.sigma[:, None]) == pytest.approx(0.01)


def test_where_nothing_was_recorded_nothing_walks() -> None:
    assert steps_of_a_walk(small(np.random.default_rng(1)), "gyroscope").shape == (36, 0)
