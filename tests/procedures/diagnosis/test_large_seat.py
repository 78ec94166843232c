"""A seat of some milliradians takes from the upright sensor in second order what five sigmas of its bias are."""

from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.diagnosis.diagnose import diagnose

SHORT = (1, 3, 5, 7, 8, 9, 11)
SEAT = {"placement.dwell": {"position": 3.0, "y": -4e-3, "z": -3e-3}}


def test_bias_and_scale_factor_are_right_with_the_cube_on_a_large_crumb() -> None:
    off = list[float]()
    for seed in range(5):
        truth = replace(Truth.example(seed), sample_period_s=0.05, effects=SEAT)
        campaign = simulate_campaign(
            truth, seed, dwell_s=8.0, positions=SHORT, turns=(), certificate_sigma=5e-6, moves=True
        )
        found = diagnose([campaign])
        assert found.findings[0].effect == "placement.dwell"
        assert found.solution is not None
        triad = found.solution.accelerometer
        assert triad is not None
        for one, true in ((triad.bias, truth.accel_d_g), (triad.scale_factor, truth.accel_k)):
            off += ((one.value - true) / one.std).tolist()
    assert np.abs(off).max() < 3
    assert np.sqrt(np.mean(np.square(off))) < 1.5
