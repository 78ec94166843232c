"""The latitude that gyroscopes measure, of simulated units that stood at another one than is stated."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, solve
from procedures.campaign.campaign import Campaign
from procedures.geodesy import earth_rate_n
from procedures.twelve_positions.gyroscope_fit import (
    GyroscopeFit,
    MeasuredLatitude,
    clock_rows,
    latitude_rows,
    measured_latitude,
)


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return simulate_campaign(Truth.example(3), 3, dwell_s=30.0)


def stated_at(campaign: Campaign, degrees: float) -> Campaign:
    return replace(campaign, site=replace(campaign.site, latitude=float(np.radians(degrees))))


def measured(campaign: Campaign) -> MeasuredLatitude:
    gyroscope = fit([campaign]).gyroscope
    assert gyroscope is not None
    found = measured_latitude(gyroscope)
    assert found is not None
    return found


@pytest.mark.parametrize("seed", [3])
def test_the_right_site_is_no_contradiction(seed: int) -> None:
    campaign = simulate_campaign(Truth.example(seed), seed, dwell_s=30.0)
    found = measured(campaign)
    assert not found.contradicts
    assert abs(found.value - found.stated) < 4 * found.std
    assert found.std < np.radians(3)


@pytest.mark.parametrize("degrees", [48.0, -60.0])
def test_a_site_elsewhere_is_contradicted_and_the_right_one_measured(campaign: Campaign, degrees: float) -> None:
    true = campaign.site.latitude
    found = measured(stated_at(campaign, degrees))
    assert found.contradicts
    assert abs(found.value - true) < max(4 * found.std, np.radians(2))


def test_a_solution_warns_of_it_with_both_values(campaign: Campaign) -> None:
    assert not [text for text in solve([campaign]).warnings if "latitude" in text]
    (reported,) = [text for text in solve([stated_at(campaign, 0.0)]).warnings if "latitude" in text]
    assert "0.00 deg" in reported
    assert f"{np.degrees(measured(stated_at(campaign, 0.0)).value):.1f}" in reported


# Sensitivity to errors of the time base and of the latitude, by hand


@pytest.fixture(scope="module")
def solved() -> GyroscopeFit:
    found = fit([simulate_campaign(Truth.example(3), 3, dwell_s=10.0)]).gyroscope
    assert found is not None
    return found


def unwhitened(fitted: GyroscopeFit, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of dwells (n, 3) [output/s] and of turns (t, 3) [output]; all others are nought."""
    n, turns = len(fitted.joint.seen.dwells), len(fitted.turns)
    changed = rows[: 3 * (n + turns)].reshape(-1, 3) * np.concatenate((fitted.joint.sigma, fitted.turn_sigma))
    assert not rows[3 * (n + turns) :].any()
    return changed[:n], changed[n:]


def test_counts_of_a_clock_that_is_off_hold_as_much_more_of_rate_and_bias(solved: GyroscopeFit) -> None:
    """Of a dwell its rate but for what is left of it; of a turn what the Earth and the bias add to it."""
    dwells, turns = unwhitened(solved, clock_rows(solved, rate_output=False))
    rate = solved.joint.seen.rate
    assert np.abs(dwells - rate).max() < 5 * solved.joint.sigma.max()
    for turn, found in zip(solved.turns, turns, strict=True):
        # three turns about an axis come back to where they began: what is left of the total is Earth and bias
        full = 360.0 * round(np.linalg.norm(np.linalg.solve(solved.joint.K, turn.total)) / 360.0)
        axis = np.linalg.solve(solved.joint.K, turn.total)
        added = turn.total - solved.joint.K @ (axis / np.linalg.norm(axis) * full)
        assert np.linalg.norm(found - added) < 0.3 * np.linalg.norm(turn.total) * 1e-3


def test_rates_of_a_clock_that_is_off_change_turns_alone(solved: GyroscopeFit) -> None:
    """A turn's total is the sum of rates over a time that is longer by the error; a dwell's mean rate is none."""
    counts, rates = (unwhitened(solved, clock_rows(solved, rate_output=each)) for each in (False, True))
    assert not rates[0].any()
    totals = np.array([turn.total for turn in solved.turns])
    assert counts[1] - rates[1] == pytest.approx(totals, rel=1e-9)


def test_a_latitude_that_is_off_turns_the_earths_rate_about_east(solved: GyroscopeFit) -> None:
    """Of a dwell K times the change of the Earth's rate, as the latitude of the site grows by a radian."""
    dwells, _ = unwhitened(solved, latitude_rows(solved))
    latitude = solved.joint.bench.campaigns[0].site.latitude
    change = np.degrees(earth_rate_n(latitude + 1e-6) - earth_rate_n(latitude - 1e-6)) / 2e-6
    sizes = np.linalg.norm(np.linalg.solve(solved.joint.K, dwells.T), axis=0)
    assert sizes == pytest.approx(np.full(len(dwells), np.linalg.norm(change)), rel=1e-3)
