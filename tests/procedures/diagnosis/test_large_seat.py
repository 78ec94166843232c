"""A seat of some milliradians takes from the upright sensor in second order what five sigmas of its bias are."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.diagnosis.diagnose import diagnose

SHORT = (1, 3, 5, 7, 8, 9, 11)
SEAT = {"placement.dwell": {"position": 3.0, "y": -4e-3, "z": -3e-3}}


# of long dwells what is left is the product with the slab's tilt, which columns at nominal attitude lack
@pytest.mark.parametrize(
    ("period", "dwell_s", "named", "most"),
    [(0.05, 8.0, "placement.dwell", 3.0), (0.02, 20.0, "fixture.face_tilt", 4.6)],
)
def test_bias_and_scale_factor_are_right_with_the_cube_on_a_large_crumb(
    period: float, dwell_s: float, named: str, most: float
) -> None:
    off = list[float]()
    for seed in range(4):
        truth = replace(Truth.example(seed), sample_period_s=period, effects=SEAT)
        campaign = simulate_campaign(
            truth, seed, dwell_s=dwell_s, positions=SHORT, turns=(), certificate_sigma=5e-6, moves=True
        )
        found = diagnose([campaign])
        assert found.findings[0].effect == named
        assert found.solution is not None
        triad = found.solution.accelerometer
        assert triad is not None
        for one, true in ((triad.bias, truth.accel_d_g), (triad.scale_factor, truth.accel_k)):
            off += ((one.value - true) / one.std).tolist()
    assert np.abs(off).max() < most
    assert np.sqrt(np.mean(np.square(off))) < 1.5
