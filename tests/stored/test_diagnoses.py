"""Whole diagnoses: findings, values, verdict and what was tried, of campaigns with planted error terms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.anomalies.wrong_positions import find_wrong_labels, with_true_directions
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.campaign.plan_steps import turn_steps
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.single_channels import single_channels
from procedures.discovery.discover import discover
from procedures.inference.priors import PRESENT
from procedures.samples.sample_effects import sample_effects
from procedures.uncertainty.budget import budget
from procedures.uncertainty.sources import GivenValues
from tests.procedures.diagnosis.planted import with_reference_time
from tests.stored.conftest import StoredResult
from tests.stored.small_campaigns import CASES, campaigns_of, outcome, some_effects, stated, unit, with_table


@pytest.mark.parametrize("name", CASES)
def test_a_small_campaign(stored_result: StoredResult, name: str) -> None:
    found = diagnose(campaigns_of(CASES[name]), some_effects(*CASES[name].tried))
    stored_result.check(outcome(found), without=["gain"])
    if name == "wandering":
        proposals = discover(found).proposals
        numbers = ("coefficients", "value", "std", "share", "held_out")
        kept = [{name: getattr(each, name) for name in numbers} for each in proposals]
        assert all(each.probability > PRESENT for each in proposals)  # to how many digits hangs on all rivals
        stored_result.check(
            {"proposals": kept, "readings": [len(each.readings) for each in proposals]}, "discovered"
        )
    elif name == "soak":  # what an effect of the catalogue explains asks for no other
        assert discover(found).proposals == ()


def test_counts_with_a_rate_table_and_their_budget(stored_result: StoredResult) -> None:
    planted = {
        "accelerometer.quadratic": {"x": 3e-4, "y": -2e-4}, "gyroscope.g_sensitivity": {"xx": 3.0, "yz": -2.0},
        "clock.rate": {"value": 300.0},
        "disturbance.dwell": {
            "x": 3e-2, "y": 2e-2, "z": 1e-2, "position": 4.0, "at_s": 8.0, "duration_s": 4.0, "hz": 3.0
        },
    }  # fmt: skip
    tried = (
        "accelerometer.quadratic", "accelerometer.relaxation", "fixture.parallelism", "gyroscope.g_sensitivity",
        "gyroscope.magnetic", "gyroscope.scale_nonlinearity", "gyroscope.scale_temperature", "slab.tilt",
    )  # fmt: skip
    truth = unit(1, effects=planted)
    bench = simulate_campaign(truth, 1, dwell_s=20.0, certificate_sigma=5e-6, turns=turn_steps(2, 3.0), repeats=1)
    found = diagnose([with_table(with_reference_time(bench, 300.0, 2))], some_effects(*tried))
    parts = budget(found.after, GivenValues(clock=found.clock))
    stored_result.check({"diagnosis": outcome(found), "budget": stated(parts)})


def test_wrong_positions_and_wrong_directions(stored_result: StoredResult) -> None:
    truth = unit(4, effects={"placement.label": {"position": 4, "actual": 5}})
    campaign = simulate_campaign(truth, 4, dwell_s=20.0)
    turns = tuple(replace(each, direction="+") for each in campaign.turns)
    wrong = with_true_directions([replace(campaign, turns=turns)])
    stored_result.check({"labels": find_wrong_labels([campaign]), "directions": wrong[1]})


def test_what_acts_sample_by_sample(stored_result: StoredResult) -> None:
    """Gyroscope z periodic in a ramp that wraps, x in an angle that does not; an accelerometer that lags."""
    n, period = 12_000, 0.01
    rng, t = np.random.default_rng(1), period * np.arange(1, n + 1)
    turns = (3.7 * t + 1e-3 * np.cumsum(rng.normal(size=n))) % 1.0
    angle = np.cumsum(0.3 + 0.05 * rng.normal(size=n))
    current = lfilter([1], [1, -0.9], rng.normal(size=n))
    shaking = np.abs(np.sin(2 * np.pi * t / 17)) * rng.normal(size=n)
    gyro, accel = rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    gyro[:, 2] += 0.2 * np.cos(2 * np.pi * turns) + 0.1 * np.sin(4 * np.pi * turns)
    gyro[:, 0] += 0.25 * np.cos(np.radians(6 * angle)) + 0.02 * (t - 60) ** 2 / 60
    gyro[:, 1] += 0.3 * np.sin(2 * np.pi * 7.3 * t)
    accel[3:, 1] += 0.06 * current[:-3]
    accel[:, 2] += 3.0 * shaking
    accel[:, 0] += 0.3 * (3.0 * shaking) ** 2
    extra = {"aux_ramp": 360 * turns, "aux_motor": angle, "aux_current": current}
    series = RateSeries(t, gyro, accel, 25 + 0.02 * t, period, extra=extra)
    soak = Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=(SoakRecord("soak", 0, None, series),))
    found = sample_effects([soak], {"gyroscope": np.ones(3), "accelerometer": np.ones(3)})
    stored_result.check({"found": found, "single channels": single_channels([soak], ())})
