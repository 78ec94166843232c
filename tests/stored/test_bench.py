"""What the bench says of itself: cube, seat, heading, warm-up, tolerance."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.bench.cube_drift import compare, drift
from procedures.bench.cube_measurement import measure_cube
from procedures.bench.seating_check import judge, seating
from procedures.bench.warm_up import time_constant, warm_up
from procedures.campaign.campaign import Fixture
from procedures.diagnosis.disturbances import find_disturbances
from procedures.diagnosis.wrong_positions import find_wrong_labels
from procedures.diagnosis.wrong_turn_directions import with_true_directions
from tests.benchmarks.diagnosing.designs import unit
from tests.procedures.bench.test_seating_check import Unit
from tests.procedures.bench.test_warm_up import DWELL_S, PAIR_S, history
from tests.procedures.measured_units import campaigns
from tests.stored.held import assert_held


@pytest.mark.parametrize(("mountings", "free"), [(("as drawn", "about z", "about x"), 0), (("as drawn",), 10)])
def test_a_cube_measured_by_units(mountings: tuple[str, ...], free: int) -> None:
    rng = np.random.default_rng(3)
    faces = 3e-5 * rng.standard_normal((6, 2))
    found = [measure_cube(campaigns(rng, faces + 1e-6 * i, 1, mountings, free)) for i in range(2)]
    moved = [compare(found[0].cube, found[1].cube), drift([*found, found[0]], [0.0, 3.0, 8.0])]
    assert_held("bench", f"cube, {len(mountings)} mountings", [found, moved])


@pytest.mark.parametrize("seed", range(3))
def test_the_seat(seed: int) -> None:
    bench = Unit(seed, 1e-6)
    accepted = [bench.rests(position) for position in range(1, 9)]
    found = [seating(accepted, bench.rests(9, tilt), Fixture(), 1e-3) for tilt in ((0.0, 0.0), (3e-4, -2e-4))]
    assert_held("bench", f"seat {seed}", [found, [judge(each) for each in found if each]])


@pytest.mark.parametrize(("rise", "drift_s"), [(0.0, 0.0), (4.0, 0.0), (1.0, 1e-3)])
def test_the_warm_up(rise: float, drift_s: float) -> None:
    means = history(2, 150, rise, drift=drift_s)
    state = warm_up(means, DWELL_S, PAIR_S, (500.0,))
    constants = [time_constant(means.t, means.gyro[:, i], 1.0) for i in range(3)]
    assert_held("bench", f"warm-up {rise}, {drift_s}", [state, constants])


def test_what_is_checked_before_any_effect() -> None:
    truth = unit(4, effects={"placement.label": {"position": 4, "actual": 5}})
    campaign = simulate_campaign(truth, 4, dwell_s=20.0)
    turns = tuple(replace(each, direction="+") for each in campaign.turns)
    wrong = with_true_directions([replace(campaign, turns=turns)])
    assert_held("bench", "checks", [find_wrong_labels([campaign]), wrong[1], find_disturbances([campaign])])
