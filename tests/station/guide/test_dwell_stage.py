"""Dwells: what is accepted, what is left out, and what begins again."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.guide.view import CalibrationView
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def at(stage: str) -> Callable[[CalibrationView], bool]:
    return lambda view: view.stage == stage


def after(seconds: float) -> Callable[[CalibrationView], bool]:
    return lambda view: view.stage == "dwell" and view.accepted_s >= seconds


def accepted_seconds(rig: GuideRig) -> list[float]:
    return [view.accepted_s for view in rig.seen if view.stage == "dwell"]


def test_a_resting_cube_is_recorded_without_a_key_and_is_on_the_disk_when_accepted(rig: Make) -> None:
    guided = rig(dwells(1, seconds=12.5))
    guided.run(guided.done(1))
    [dwell] = read_campaign(guided.folder).campaign.dwells
    assert (dwell.position, len(dwell.series)) == (1, 625)
    assert verify_folder(guided.folder) == ["dwell_01.mcap"]
    assert guided.texts == ["start: recording: keep your hands off", "accepted: accepted: position 1, 1 of 1 done"]
    assert guided.guide.is_complete


def test_any_order_is_taken_and_the_wish_stays_the_first_open_step(rig: Make) -> None:
    guided = rig(dwells(1, 2, 7, 8))
    for count, position in enumerate((7, 8, 2, 1), start=1):
        guided.hands(f"place {position} 8")
        guided.run(lambda v, p=position: v.step(f"dwell_{p:02}").attempts == 1)
        assert guided.view.done == count
    assert [d.position for d in read_campaign(guided.folder).campaign.dwells] == [7, 8, 2, 1]
    assert not any(text.startswith("rejected") for text in guided.texts)


def test_a_face_with_nothing_left_to_do_is_reported_and_is_no_failure(rig: Make) -> None:
    guided = rig(dwells(1, 3))
    guided.hands("place 9 8")
    view = guided.run(lambda v: bool(v.events))
    assert view.events[-1].text == "Z points up: nothing remains to be done there"
    assert view.line.startswith("put the cube in position 1")
    assert view.stage == "place"
    for _ in range(8):  # the wrong face five times kills the run elsewhere
        guided.hands("place 9 8")
        guided.rest(20)
    guided.hands("place 1 8")
    guided.run(guided.done(1))


def test_the_same_position_again_is_known_by_the_earth_rate(rig: Make) -> None:
    guided = rig(dwells(1, 2))
    guided.run(guided.done(1))
    guided.hands("place 1 8")
    view = guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    assert view.events[-1].text == "position 1 is done already; position 2 is the same face turned by 180 deg"
    guided.hands("place 2 8")
    guided.run(guided.done(2))


@pytest.mark.parametrize(("turn", "sense"), [(90, "clockwise"), (-90, "counter-clockwise")])
def test_a_cube_turned_by_90_deg_is_shown_the_way_to_the_position_that_is_wanted(
    rig: Make, turn: int, sense: str
) -> None:
    guided = rig(dwells(3))
    guided.hands(f"place 3 8 {-turn} 0 0")  # x is down
    view = guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    assert f"turn 90 deg more, {sense} from above, to position 3" in view.events[-1].text


def test_where_the_earth_rate_does_not_determine_it_is_asked(rig: Make) -> None:
    guided = rig(dwells(5, 6, seconds=20.0), replace(Truth.example(3), latitude_deg=89.5))
    guided.hands("place 6 8")
    view = guided.run(lambda v: v.question is not None)
    assert [choice.key for choice in view.question.choices] == ["5", "6", "n"]
    assert "position 6: X north, Y up, Z east" in view.question.choices[1].title
    guided.run(lambda v: "accepted when the heading" in v.hint)  # the dwell is complete and waits
    guided.rest(30)
    assert guided.view.done == 0
    guided.execute("answer", key="6")
    guided.run(guided.done(1))
    assert guided.view.gates.heading in {"as you answered", ""}
    assert [d.position for d in read_campaign(guided.folder).campaign.dwells] == [6]


def test_a_cube_that_is_in_neither_position_is_set_down_again(rig: Make) -> None:
    guided = rig(dwells(5, seconds=10.0), replace(Truth.example(3), latitude_deg=89.5))
    guided.hands("place 5 8")
    guided.run(lambda v: v.question is not None)
    guided.execute("answer", key="n")
    view = guided.run(lambda v: v.question is None)
    assert (view.stage, view.hint) == ("place", "set the cube down along the marks on the surface plate")
    guided.hands("place 5 8")
    guided.run(lambda v: v.question is not None)
    guided.execute("answer", key="5")
    guided.run(guided.done(1))


def test_a_shock_costs_the_disturbed_seconds_only_and_the_bar_never_falls(rig: Make) -> None:
    guided = rig(dwells(1, seconds=30.0))
    guided.run(after(25.0))
    guided.hands("shock 7 0.05")
    guided.run(guided.done(1))
    seconds = accepted_seconds(guided)
    assert np.min(np.diff(seconds)) >= 0
    assert "still: disturbed: keep still, only the affected seconds are discarded" in guided.texts
    assert len(read_campaign(guided.folder).campaign.dwells[0].series.starts) > 1


@pytest.mark.parametrize(("after_s", "when"), [(20.0, ""), (2.0, " just after placement")])
def test_a_cube_that_was_turned_a_little_is_to_be_set_along_the_marks_again(
    rig: Make, after_s: float, when: str
) -> None:
    guided = rig(dwells(1, seconds=30.0))
    guided.run(after(after_s))
    guided.hands("creep 2 0.3 0 0")  # about the vertical: no accelerometer sees it
    guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    found = re.fullmatch(
        r"rejected: the cube was moved by (0\.\d\d) deg(.*); lift it and .* marks", guided.texts[-1]
    )
    assert found is not None
    assert float(found[1]) == pytest.approx(0.3, abs=0.07)  # k is rough
    assert found[2] == when
    with pytest.raises(AssertionError):
        guided.run(guided.done(1), seconds=60.0)  # it waits until it was lifted
    guided.hands("place 1 8")
    guided.run(guided.done(1))


def test_a_slow_creep_is_seen_at_the_end(rig: Make) -> None:
    guided = rig(dwells(1, seconds=100.0))
    guided.hands("creep 200 0 0.1 0")  # 2 arcsec a second
    guided.run(lambda v: any(e.sound == "rejected" for e in v.events))
    assert "the cube moved slowly by" in guided.texts[-1]
    assert guided.view.done == 0


def test_the_angle_of_a_tilted_cube_is_shown_and_it_is_never_recorded(rig: Make) -> None:
    guided = rig(dwells(1, seconds=5.0))
    guided.hands("place 1 8 0 4 0")
    guided.rest(60)
    view = guided.view
    assert view.hint.startswith("tilted by 4.")
    assert view.gates.off_deg == pytest.approx(4.0, abs=0.6)  # the biases are not known yet
    assert not view.gates.is_right_face
    assert view.gates.is_still
    assert view.done == 0


def test_a_dwell_across_an_unplug_is_rejected(rig: Make) -> None:
    guided = rig(dwells(1, seconds=30.0), faults=[Fault("unplug", at_s=25.0, seconds=5.0)])
    guided.run(guided.done(1))
    assert "rejected: the data stream was interrupted; the dwell starts again" in guided.texts
    series = read_campaign(guided.folder).campaign.dwells[0].series
    assert series.t[0] > 30.0
    assert len(series.starts) == 1


def test_a_lost_frame_splits_a_dwell(rig: Make) -> None:
    guided = rig(dwells(1, seconds=30.0), faults=[Fault("lost", at_s=25.006, count=3)])
    view = guided.run(guided.done(1))
    assert len(read_campaign(guided.folder).campaign.dwells[0].series.starts) == 2
    assert view.link.lost == 3


def test_a_step_done_again_supersedes_and_keeps_the_old_file(rig: Make) -> None:
    guided = rig(dwells(1, 2))
    guided.run(guided.done(1))
    guided.execute("redo")
    assert guided.view.wanted == "dwell_01"
    assert guided.view.step("dwell_01").state == "redo"
    view = guided.run(lambda v: v.step("dwell_01").attempts == 2)  # where it stands, nobody need lift it
    assert view.step("dwell_01").superseded == 1
    assert [d.name for d in read_campaign(guided.folder).campaign.dwells] == ["dwell_01_2.mcap"]
    assert verify_folder(guided.folder) == ["dwell_01.mcap", "dwell_01_2.mcap"]
    assert view.wanted == "dwell_02"


@pytest.mark.parametrize("when", ["place", "dwell"])
def test_a_pause_keeps_what_was_accepted_and_records_nothing(rig: Make, when: str) -> None:
    guided = rig(dwells(1, seconds=20.0))
    if when == "place":
        guided.hands("place 5 5")  # off the face that is wanted
        guided.hands("rest 40")
        guided.hands("place 1 5")
    guided.run(at(when) if when != "dwell" else after(10.0))
    before = guided.view.accepted_s
    guided.execute("pause")
    view = guided.rest(60)
    assert (view.stage, view.hint) == ("paused", "p goes on")
    assert (view.done, view.accepted_s) == (0, before)
    guided.execute("go_on")
    guided.run(guided.done(1))
    assert np.min(np.diff(accepted_seconds(guided))) >= 0


def test_a_cube_that_was_lifted_begins_again_in_whatever_position_it_comes_down(rig: Make) -> None:
    guided = rig(dwells(1, 4, seconds=30.0))
    guided.run(after(20.0))
    guided.hands("place 4 8")
    guided.run(guided.done(1))
    assert any("the cube was lifted or tilted" in text for text in guided.texts)
    assert [d.position for d in read_campaign(guided.folder).campaign.dwells] == [4]
