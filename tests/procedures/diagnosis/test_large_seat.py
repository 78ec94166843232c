"""A seat of some milliradians takes from the upright sensor in second order what five sigmas of its bias are."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.diagnosis.diagnose import diagnose

SHORT = (1, 3, 5, 7, 8, 9, 11)
SEAT = {"placement.dwell": {"position": 3.0, "y": -4e-3, "z": -3e-3}}


@pytest.mark.proof
def test_bias_and_scale_factor_are_right_with_the_cube_on_large_debris() -> None:
    truth = replace(Truth.example(0), sample_period_s=0.05, effects=SEAT)
    campaign = simulate_campaign(
        truth, 0, dwell_s=8.0, positions=SHORT, turns=(), certificate_sigma=5e-6, moves=True
    )
    found = diagnose([campaign])
    assert next(each.effect for each in found.findings if each.effect != "slab.tilt") == "placement.dwell"
    triad = found.solution.accelerometer
    assert triad is not None
    for one, true in ((triad.bias, truth.accel_d_g), (triad.scale_factor, truth.accel_k)):
        assert np.abs((one.value - true) / one.std).max() < 3.0
