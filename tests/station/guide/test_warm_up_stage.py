"""Warm-up: positions begin once the unit has settled; skipping is recorded and said."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from drivers.simulated.truth import Truth
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.campaign_folder.plan_file import kept_plan
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]
HEATING = replace(
    Truth.example(4), temperature_rise_k=10.0, temperature_tau_s=600.0,
    effects={"gyroscope.bias_temperature": {"x": 0.05, "y": 0.05, "z": 0.05}},
)  # fmt: skip


def test_a_settled_unit_begins_within_two_minutes(rig: Make) -> None:
    guided = rig(dwells(1, seconds=20.0), warms_up=True)
    view = guided.run(lambda v: v.stage != "warm_up", seconds=120)
    assert "start: the unit has settled; positions may begin" in guided.texts
    guided.run(guided.done(1))
    assert view.warm_up is None


@pytest.mark.proof
def test_a_heating_unit_waits_and_says_how_long(rig: Make) -> None:
    guided = rig(dwells(1, seconds=100.0), HEATING, warms_up=True)
    view = guided.rest(300)
    assert view.stage == "warm_up"
    assert view.warm_up.temperature_rate_c_min > view.warm_up.temperature_limit_c_min
    assert 60 < view.warm_up.left_s < 6000
    guided.run(lambda v: v.stage != "warm_up", seconds=6000)


def test_a_skipped_warm_up_is_recorded_and_widens_the_sigma(rig: Make) -> None:
    guided = rig(dwells(1, seconds=20.0), HEATING, warms_up=True)
    guided.execute("skip_warm_up")
    assert guided.view.stage == "warm_up"  # not before anything is known
    guided.rest(100)
    guided.execute("skip_warm_up")
    guided.run(guided.done(1))
    procedure = read_campaign_toml(guided.folder)[0].procedure
    assert procedure.unsettled_gyro_deg_h > 0.01
    assert read_campaign(guided.folder).campaign.sigma.unsettled_gyro > 0
    assert any("warm-up was skipped" in text for text in guided.texts)


@pytest.mark.parametrize("bias_ug", [1.0, 0.1])
def test_the_dwells_last_as_long_as_the_sigma_wanted_asks_for(rig: Make, bias_ug: float) -> None:
    guided = rig(dwells(1, 2), warms_up=True, bias_std=bias_ug * 1e-6)
    guided.run(lambda v: v.stage != "warm_up", seconds=200)
    seconds = {step.seconds for step in kept_plan(guided.folder)}
    assert len(seconds) == 1
    assert seconds == {step.seconds for step in guided.context.checklist.steps}
    assert (10 <= seconds.pop() < 30) if bias_ug == 1.0 else seconds.pop() > 30
