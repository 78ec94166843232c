"""Six faces of one heading leave the slab's tilt open: what it moves in second order is in the sigma of k."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, report
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import SECOND_ORDER

SIX_FACES = (1, 3, 5, 7, 9, 11)


def test_an_open_slab_tilt_is_in_the_sigma_of_k_in_second_order() -> None:
    off = list[float]()
    for seed in range(12):
        truth = replace(Truth.example(seed), slab_tilt_rad=np.random.default_rng(seed).normal(0.0, 3.5e-3, 2))
        found = report(fit([simulate_campaign(truth, seed, dwell_s=20.0, positions=SIX_FACES, turns=())]))
        assert found.accelerometer is not None
        k = found.accelerometer.scale_factor
        off += ((k.value - truth.accel_k) / k.std).tolist()
    assert np.abs(off).max() < 4


def test_the_budget_names_it_and_adds_up() -> None:
    truth = Truth.example(3)
    fits = fit([simulate_campaign(truth, 3, dwell_s=20.0, positions=SIX_FACES, turns=())])
    triad = report(fits).accelerometer
    assert triad is not None
    for i, one in enumerate(budget(fits)[:3]):
        assert any(part.source == SECOND_ORDER for part in one.contributions)
        assert np.isclose(one.std, triad.scale_factor.std[i], rtol=0.02)


def test_pairs_of_headings_leave_nothing_open() -> None:
    fits = fit([simulate_campaign(Truth.example(3), 3, dwell_s=20.0)])
    assert not any(part.source == SECOND_ORDER for one in budget(fits) for part in one.contributions)
