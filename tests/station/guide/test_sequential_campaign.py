"""Campaigns that go on until what is wanted is met: asked for, ended, stopped, resumed, done again."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.plan_steps import Dwell
from procedures.planning.campaign_design import CampaignDesign, Placement
from procedures.planning.least_time import NextPlacement
from station.files.campaign_folder.plan_file import WantedRecord
from station.guide.campaign import sequential_campaign
from station.guide.campaign.accepted_steps import AcceptedDwell
from station.guide.campaign.sequential_campaign import NOISE_S, SequentialCampaign
from tests.procedures.planning.bench_of_moves import HALVES, bench, order, unit
from tests.station.guide.rig import GuideRig

Make = Callable[..., GuideRig]
ASKED = (1, 2, 3, 5)
WANTED = WantedRecord(
    sigmas={f"gyroscope.bias.{axis}": 0.02 for axis in "xyz"}, accel_white=(1.4e-6,) * 3, gyro_white=(1e-4,) * 3,
    accel_scale=(1e3,) * 3, gyro_scale=(36e3,) * 3, wander=3e-6, placing_s=45.0, move_s=25.0,
)  # fmt: skip


@pytest.fixture
def ruled(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rule that is no search: `ASKED` in turn for 20 s, three are enough once the third has lasted 12 s."""

    def following(
        _sigmas: object, _wanted: object, done: list[Placement], *, goes_on: bool = False
    ) -> NextPlacement:
        so_far, sigmas = CampaignDesign(tuple(done)), np.full(30, np.inf)
        if len(done) >= 3 and not goes_on:
            return NextPlacement(None, 0.0, sigmas, so_far)
        placement = Placement(ASKED[len(done)], 20.0)
        return NextPlacement(placement, 65.0, sigmas, CampaignDesign((*done, placement)))

    def is_enough(_sigmas: object, _wanted: object, so_far: CampaignDesign) -> bool:
        return len(so_far.positions) == 3 and so_far.placements[-1].seconds >= 12

    monkeypatch.setattr(sequential_campaign, "next_placement", following)
    monkeypatch.setattr(sequential_campaign, "is_enough", is_enough)


def test_the_guide_asks_for_what_comes_next_ends_a_dwell_that_is_enough_and_stops(ruled: None, rig: Make) -> None:
    guided = rig([], wanted=WANTED)
    for i, position in enumerate(ASKED[:3]):
        assert guided.view.wanted == f"dwell_{position:02d}"
        assert not guided.view.can_do_more
        guided.hands(f"place {position} 8")
        guided.run(guided.done(i + 1))
    assert guided.guide.is_complete
    assert [round(step.seconds) for step in guided.view.steps] == [20, 20, 12]
    assert guided.view.limits[0].text.startswith("gyroscope bias ")
    assert any("of 0.0200 deg/h, about 2 min left" in text for text in guided.texts)
    assert guided.texts[-1].endswith("all targets are met")
    guided.execute("more")
    assert guided.view.wanted == "dwell_05"


def test_a_campaign_that_is_resumed_goes_on_and_a_step_done_again_counts_once(ruled: None, rig: Make) -> None:
    guided = rig([], wanted=WANTED)
    for i, position in enumerate(ASKED[:2]):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(i + 1))
    guided.resume()
    assert guided.view.wanted == "dwell_03"
    guided.execute("redo", step="dwell_01")
    guided.hands("place 1 8")
    guided.run(lambda view: view.step("dwell_01").attempts == 2)
    assert guided.view.wanted == "dwell_03"
    assert len(guided.view.steps) == 3


UNKNOWN = WantedRecord(sigmas=WANTED.sigmas, placing_s=45.0, move_s=25.0)


def test_a_unit_of_which_nothing_is_known_shows_its_noise_in_the_first_two_minutes(ruled: None, rig: Make) -> None:
    guided = rig([], wanted=UNKNOWN)
    assert guided.view.limits == ()
    assert guided.view.wanted == "dwell_01"
    assert [step.seconds for step in guided.context.checklist.steps] == [NOISE_S]
    guided.hands("place 1 8")
    guided.run(guided.done(1))
    assert guided.view.limits[0].text.startswith("gyroscope bias ")
    assert guided.view.wanted == "dwell_02"
    guided.resume()
    assert guided.view.limits[0].text.startswith("gyroscope bias ")
    assert guided.view.wanted == "dwell_02"
    noise, truth = guided.context.planner.noise, guided.truth
    assert np.median(noise.gyro_white) == pytest.approx(truth.gyro_arw_deg_rt_s, rel=0.5)
    white = truth.accel_noise_g * np.sqrt(truth.sample_period_s)
    assert np.median(noise.accel_white) == pytest.approx(white, rel=0.5)


def done(*, carried: bool = True) -> SequentialCampaign:
    """Return a campaign of seven placings of 45 s."""
    placements = [replace(at, is_carried=carried) for at in order(HALVES[:7], 45.0).placements]
    return SequentialCampaign(
        bench(unit()).steps.campaign, WANTED, [(f"step {i}", at) for i, at in enumerate(placements)]
    )


def test_moves_that_are_missing_and_noise_that_is_larger_leave_more_to_do() -> None:
    campaign, apart = done(), done(carried=False)
    share = campaign.limits(None, 0.0, is_carried=True)[0].share
    assert 0.3 < share < 1
    assert apart.limits(None, 0.0, is_carried=True)[0].share < share
    std = np.sqrt(unit(instability=0.0).gyro_variance(np.array([45.0]))[0])
    loud = AcceptedDwell(Dwell(1, 45.0), np.zeros(3), np.full(3, 1e-4), np.zeros(3), 2 * 36e3 * std)
    campaign.accepted(loud.step, 45.0, is_carried=True)
    longer = campaign.limits(None, 0.0, is_carried=True)[0].share
    campaign.learn([loud])
    assert share < longer
    assert campaign.limits(None, 0.0, is_carried=True)[0].share < longer
