from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from procedures.anomalies.disturbances import find_disturbances, rough_scale, without_disturbances
from procedures.anomalies.disturbed_blocks import ChannelSamples, bent_strip_width, judge_blocks, strip_width
from procedures.calibration.joint_calibration import solve
from procedures.campaign.campaign import Campaign
from procedures.inference.odds import log_odds
from tests.procedures.diagnosis.planted import lively, planted


def disturbed(seed: int, size: float, dwell_s: float = 30.0) -> tuple[Campaign, int, np.ndarray]:
    """Return a campaign with a vibration of about ``size`` [g] in one dwell, that dwell, and the amplitudes."""
    rng = np.random.default_rng(seed)
    amplitude = size * rng.uniform(0.3, 1.0, 3)
    position = int(rng.integers(1, 13))
    effect = {"x": amplitude[0], "y": amplitude[1], "z": amplitude[2], "position": float(position),
              "at_s": 15.0, "duration_s": float(rng.uniform(2, 8)), "hz": float(rng.uniform(3, 15))}  # fmt: skip
    return planted(seed, {"disturbance.dwell": effect}, dwell_s), position, amplitude


def test_a_vibration_is_found_where_it_was_and_as_large_as_it_was() -> None:
    missed, beyond = 0, 0
    for seed in range(3):
        campaign, position, amplitude = disturbed(seed, (5e-3, 1e-2, 3e-2)[seed % 3])
        found, _ = find_disturbances([campaign])
        assert {each.finding.where["position"] for each in found} <= {position}
        missed += not found
        for each in found[:1]:
            beyond += bool(np.any(np.abs(each.finding.value - amplitude) > 4 * each.finding.std))
    assert missed == 0
    assert beyond == 0


def test_a_shock_seen_by_the_gyroscopes_alone_is_given_in_their_unit() -> None:
    campaign = planted(4, dwell_s=30.0, turns=True)
    dwell = campaign.dwells[5]
    gyro = dwell.series.gyro
    assert gyro is not None
    shaken = gyro.copy()
    shaken[500:700] += np.random.default_rng(4).integers(-2, 3, (200, 3))  # variance 2
    dwells = list(campaign.dwells)
    dwells[5] = replace(dwell, series=replace(dwell.series, gyro=shaken))
    (found,), _ = find_disturbances([replace(campaign, dwells=tuple(dwells))])
    expected = np.sqrt(2 * 2.0) / (0.02 * 10)  # counts a sample over 36000 count/deg, as deg/h
    assert found.finding.unit == "deg/h"
    assert found.finding.where["position"] == 6
    assert np.all(np.abs(found.finding.value - expected) < 4 * found.finding.std)


def test_quiet_campaigns_hold_no_disturbance() -> None:
    called = sum(bool(find_disturbances([planted(seed, dwell_s=15.0)])[0]) for seed in range(3))
    called += sum(bool(find_disturbances([planted(seed, lively(seed), 15.0)])[0]) for seed in range(2))
    assert called == 0


def test_without_the_disturbed_stretch_or_its_line_the_solution_is_the_quiet_one() -> None:
    effect = {"x": 0.05, "y": 0.05, "z": 0.05, "position": 7.0, "at_s": 12.0, "duration_s": 3.3, "hz": 0.7}
    campaign = planted(6, {"disturbance.dwell": effect}, 30.0)
    found, _ = find_disturbances([campaign])
    (cut,) = without_disturbances([campaign], found)
    series = cut.dwells[6].series
    assert len(series) < len(campaign.dwells[6].series)
    assert list(series.starts[:1]) == [0]
    assert np.all(np.diff(series.t)[series.starts[1:] - 1] > 3.0)
    got, expected = (solve([each]).accelerometer for each in (cut, planted(6, dwell_s=30.0)))
    shaken = solve([campaign]).accelerometer
    assert got is not None
    assert expected is not None
    assert shaken is not None
    assert np.all(np.abs(got.bias.value - expected.bias.value) < 4 * got.bias.std)
    assert np.all(np.abs(shaken.bias.value - expected.bias.value) < 4 * shaken.bias.std)  # its line is subtracted


@pytest.mark.parametrize("seed", range(10))
def test_counts_of_an_even_rate_lie_in_a_strip_of_less_than_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate, remainder = rng.uniform(-30, 30, (100, 1)), rng.random((100, 1))
    t = np.arange(101)
    count = np.floor(rate * t + remainder)
    assert np.max(strip_width(count)) < 1 + 1e-3
    drifting = np.floor(rate * t + remainder + rng.uniform(-1e-4, 1e-4, (100, 1)) * t**2)
    assert np.max(bent_strip_width(drifting)) < 1 + 5e-3
    swinging = np.floor(rate * t + remainder + 0.2 * np.sin(0.9 * t))
    assert np.median(strip_width(swinging)) > 1.2


def test_rough_scales_are_the_units_to_a_percent_in_output_per_g_and_per_deg_h() -> None:
    truth, campaign = Truth.example(6), planted(6, dwell_s=2.0, turns=True)
    assert np.all(np.abs(rough_scale(campaign, "accelerometer") / truth.accel_k - 1) < 0.01)
    assert np.all(np.abs(rough_scale(campaign, "gyroscope") / (truth.gyro_k / 3600) - 1) < 0.01)
    of_one = replace(campaign, dwells=campaign.dwells[:1])  # two axes have not been up: the third stands in
    assert np.all(np.abs(rough_scale(of_one, "accelerometer") / truth.accel_k - 1) < 0.15)
    nothing = replace(campaign, dwells=(), turns=(), nominal_scale={"accelerometer": 970.0})
    assert list(rough_scale(nothing, "accelerometer")) == [970.0] * 3


# Blocks of coarse counts: a steady rise of a rate is no shock, a jump is


PERIOD, SAMPLES = 0.02, 5000
JUDGED = 8000  # blocks


def channel(seed: int, run_up: float = 0.0, jump: float = 0.0) -> ChannelSamples:
    """0.3 counts a sample, which grow by ``run_up`` over the dwell; ``jump`` counts in its middle second."""
    rng, i = np.random.default_rng(seed), np.arange(SAMPLES)
    rate = 0.3 + run_up * i / SAMPLES + jump / 50 * (abs(i - SAMPLES / 2) < 25)
    total = rng.random() + np.cumsum(rate + 0.01 * rng.standard_normal(SAMPLES))
    return ChannelSamples(np.diff(np.floor(total), prepend=0.0), np.zeros(1, np.int64), PERIOD)


def most(channels: list[ChannelSamples]) -> float:
    gain = max(float(blocks.gain[blocks.trace == 0].max()) for blocks in judge_blocks(channels, True))
    return log_odds(gain, JUDGED)


@pytest.mark.parametrize("seed", [0])
def test_a_rate_that_runs_up_is_distinguished_from_a_jump(seed: int) -> None:
    quiet = [channel(10 * seed + k) for k in range(1, 4)]
    assert most([channel(seed), *quiet]) < 0
    assert most([channel(seed, run_up=1.0), *quiet]) < 0  # 3 counts off a line in ten seconds
    assert most([channel(seed, jump=6.0), *quiet]) > 0
