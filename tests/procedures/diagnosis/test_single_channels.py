"""What a one-axis gyroscope shows by itself, in counts and in rates, is what was planted."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign, SoakRecord
from procedures.campaign.plan_steps import Dwell
from procedures.diagnosis.single_channels import single_channels

PER_KELVIN = 1e-3  # deg/s per K
TRUTH = replace(
    Truth.example(7), sample_period_s=0.05, temperature_rise_k=10.0, temperature_tau_s=300.0,
    gyro_arw_deg_rt_s=1e-4, gyro_instability_dph=0.0,
    effects={"gyroscope.bias_temperature": {"x": 3600 * PER_KELVIN}},
)  # fmt: skip


@pytest.fixture(scope="module")
def one_axis() -> Campaign:
    campaign = simulate_campaign(TRUTH, 7, dwell_s=10.0, positions=(1, 2))
    soak = SimulatedBench(TRUTH, 7).perform(Dwell(1, 900.0))
    soaks = (SoakRecord("soak", 1, None, replace(soak, gyro=soak.gyro * [1, 0, 0], accel=None)),)
    turns = tuple(replace(t, series=replace(t.series, gyro=t.series.gyro * [1, 0, 0])) for t in campaign.turns)
    return replace(campaign, dwells=(), turns=turns, soaks=soaks)


def test_noise_drift_temperature_and_scale_factor_of_one_gyroscope(one_axis: Campaign) -> None:
    [found] = single_channels([one_axis], ())
    assert (found.triad, found.axis, found.recording) == ("gyroscope", "x", "soak")
    assert found.scale is not None
    scale, std = found.scale
    k = TRUTH.gyro_k[0] * TRUTH.gyro_e[0, 0]
    assert abs(scale - k) < 4 * std
    assert std < 2e-4 * k
    assert found.noise.low < 1e-4 * k < found.noise.high
    assert found.warming is not None
    assert found.kelvin > 7
    assert abs(found.warming.slope / k - PER_KELVIN) < min(4 * found.warming.std / k, 0.02 * PER_KELVIN)


def test_a_solved_triad_has_no_single_channels_and_a_whole_one_that_is_not_has_three(one_axis: Campaign) -> None:
    assert single_channels([one_axis], ("gyroscope",)) == []
    whole = simulate_campaign(TRUTH, 7, dwell_s=60.0, positions=(1, 2), turns=())
    found = single_channels([whole], ("gyroscope",))
    assert [(each.triad, each.axis) for each in found] == [("accelerometer", axis) for axis in "xyz"]


def test_without_two_directions_there_is_no_scale_factor(one_axis: Campaign) -> None:
    only = tuple(turn for turn in one_axis.turns if turn.direction == "+")
    [found] = single_channels([replace(one_axis, turns=only)], ())
    assert found.scale is None
    assert np.isfinite(found.mean)
