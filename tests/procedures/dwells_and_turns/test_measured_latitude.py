"""The latitude that gyroscopes measure, of simulated units that stood at another one than is stated."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, solve
from procedures.campaign.campaign import Campaign
from procedures.dwells_and_turns.measured_latitude import MeasuredLatitude, measured_latitude


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


@pytest.mark.parametrize("seed", [3, 4])
def test_the_right_site_is_no_contradiction(seed: int) -> None:
    campaign = simulate_campaign(Truth.example(seed), seed, dwell_s=30.0)
    found = measured(campaign)
    assert not found.contradicts
    assert abs(found.value - found.stated) < 4 * found.std
    assert found.std < np.radians(3)


@pytest.mark.parametrize("degrees", [0.0, 48.0, -60.0])
def test_a_site_elsewhere_is_contradicted_and_the_right_one_measured(campaign: Campaign, degrees: float) -> None:
    true = campaign.site.latitude
    found = measured(stated_at(campaign, degrees))
    assert found.contradicts
    assert abs(found.value - true) < max(4 * found.std, np.radians(2))


def test_a_solution_warns_of_it_with_both_values(campaign: Campaign) -> None:
    assert not [text for text in solve([campaign]).warnings if "latitude" in text]
    (said,) = [text for text in solve([stated_at(campaign, 0.0)]).warnings if "latitude" in text]
    assert "0.00 deg" in said
    assert f"{np.degrees(measured(stated_at(campaign, 0.0)).value):.1f}" in said
