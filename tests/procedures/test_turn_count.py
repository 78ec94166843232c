"""A turn's counts: revolutions, and how far two opposite turns came back, from simulated hands."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench import SimulatedBench
from drivers.simulated.truth import Truth
from procedures.hand_turns import TURN_START
from procedures.steps import Dwell, Turn
from procedures.turn_count import Turned, came_back, revolutions, turned

AXES = "xyz"


def turn_of(bench: SimulatedBench, axis: str, direction: str, whole: int = 3) -> Turned:
    """A turn with the rate at rest from a dwell of a minute before it."""
    k, start = AXES.index(axis), TURN_START[axis]
    rest, turn = bench.perform(Dwell(start, 60.0)), bench.perform(Turn(axis, direction, whole, start, 5.0))
    assert rest.gyro is not None
    assert turn.gyro is not None
    noise = bench.truth.gyro_arw_deg_rt_s * bench.truth.gyro_k[k]
    rate, seconds = rest.gyro[:, k].sum() / 60.0, len(turn) * turn.period
    return turned(turn.gyro[:, k].sum(), seconds, rate, noise / np.sqrt(60.0), noise)


@pytest.mark.parametrize("axis", AXES)
def test_a_turn_that_did_not_close_is_seen_against_the_opposite_one(axis: str) -> None:
    """The second turn ends half a degree too far; both have another bias and scale factor than nominal."""
    truth = replace(Truth.example(4), closure_std_deg=0.0, gyro_instability_dph=0.0)
    bench = SimulatedBench(truth, 4)
    plus = turn_of(bench, axis, "+")
    clean, std = came_back(turn_of(bench, axis, "-"), plus, 3)
    # misaligned gyros see the horizontal Earth rate: 1e-3 of 15 deg/h for a minute
    assert abs(clean) < 4 * std + np.radians(5e-4)
    assert np.degrees(std) < 5e-3
    minus = turn_of(bench, axis, "-")
    k = truth.gyro_k[AXES.index(axis)]
    open_end = replace(minus, counts=minus.counts - 0.5 * k)
    assert np.degrees(came_back(open_end, plus, 3)[0] - came_back(minus, plus, 3)[0]) == pytest.approx(
        0.5, rel=1e-3
    )


def test_simulated_closures_scatter_as_the_sigma_says() -> None:
    truth = replace(Truth.example(5), closure_std_deg=0.02, gyro_instability_dph=0.0)
    bench = SimulatedBench(truth, 5)
    found = [came_back(turn_of(bench, axis, "-", 1), turn_of(bench, axis, "+", 1), 1) for axis in 3 * AXES]
    z = [net / np.hypot(std, np.sqrt(2) * np.radians(0.02)) for net, std in found]
    assert np.abs(z).max() < 4
    assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.8


def test_revolutions_are_counted_from_a_rough_scale_factor() -> None:
    assert revolutions(-3 * 2 * np.pi * 2e6, 2e6) == pytest.approx(-3.0)
