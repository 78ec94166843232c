"""A seat of some milliradians takes from the upright sensor in second order what five sigmas of its bias are."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.diagnosis.diagnose import diagnose

SHORT = (1, 3, 5, 7, 8, 9, 11)
SEAT = {"placement.dwell": {"position": 3.0, "y": -4e-3, "z": -3e-3}}
SLANTING = np.array([2e-3, -1.5e-3])  # rad, of the slab


# of long dwells the face's tilt is as likely as the seat, and what is not known of it bends bias and scale factor
@pytest.mark.parametrize(
    ("period", "dwell_s", "slab", "named", "seeds"),
    [
        (0.05, 8.0, None, "placement.dwell", (0,)),
        (0.02, 20.0, None, "fixture.face_tilt", (2,)),
        (0.05, 8.0, SLANTING, "placement.dwell", (1,)),
    ],
)
def test_bias_and_scale_factor_are_right_with_the_cube_on_a_large_crumb(
    period: float, dwell_s: float, slab: FloatArray | None, named: str, seeds: tuple[int, ...]
) -> None:
    off = list[float]()
    for seed in seeds:
        truth = replace(Truth.example(seed), sample_period_s=period, effects=SEAT)
        truth = truth if slab is None else replace(truth, slab_tilt_rad=slab)
        campaign = simulate_campaign(
            truth, seed, dwell_s=dwell_s, positions=SHORT, turns=(), certificate_sigma=5e-6, moves=True
        )
        found = diagnose([campaign])
        others = [each.effect for each in found.findings if each.effect != "slab.tilt"]  # it leans, and is found
        assert others[0] == named
        assert found.solution is not None
        triad = found.solution.accelerometer
        assert triad is not None
        for one, true in ((triad.bias, truth.accel_d_g), (triad.scale_factor, truth.accel_k)):
            off += ((one.value - true) / one.std).tolist()
    assert np.abs(off).max() < 3.0
    assert np.sqrt(np.mean(np.square(off))) < 1.5
