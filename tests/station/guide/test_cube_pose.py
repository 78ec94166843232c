"""The cube as it stands, followed from the counts while hands carry it; a heading that is wrong is said."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.positions import nominal_C_lb
from station.guide.view import PoseView
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def off_deg(pose: PoseView, position: int) -> float:
    """Return the angle between an attitude and a position's."""
    between = np.array(pose.C_lb).T @ nominal_C_lb(position)
    return float(np.degrees(np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))))


def test_a_whole_campaign_is_followed_from_position_to_position(rig: Make) -> None:
    order = (1, 2, 4, 3, 5, 8, 12)
    guided = rig(dwells(*order))
    for count, position in enumerate(order, start=1):
        if count > 1:
            guided.hands(f"place {position} 8")
        view = guided.run(guided.done(count))
        assert off_deg(view.pose, position) < 8, position
        assert view.pose.heading_std_deg < 8


def test_it_turns_on_the_screen_while_hands_turn_it_and_counts_down_what_is_left(rig: Make) -> None:
    guided = rig(dwells(1, 2))
    view = guided.run(guided.done(1))
    assert abs(view.pose.turn_deg) > 170
    assert view.pose.text.startswith("turn 1")
    guided.hands("place 2 12")
    left = list[float]()
    guided.run(lambda v: v.live == "dwell_02", lambda v: left.append(abs(v.pose.turn_deg)))
    assert any(100 < each < 170 for each in left)
    assert any(20 < each < 100 for each in left)
    assert left[-1] < 8
    assert guided.view.pose.text == "the position is correct"


def test_before_anything_determined_the_heading_it_is_reported_as_unknown(rig: Make) -> None:
    guided = rig(dwells(1), replace(Truth.example(1), latitude_deg=89.9))
    view = guided.rest(12)
    assert view.pose.heading_std_deg is None
    assert view.pose.turn_deg is None
    assert view.pose.text == "its heading is not known yet"


def test_a_heading_that_stays_wrong_on_the_right_face_is_reported_after_20_s_and_once(rig: Make) -> None:
    guided = rig(dwells(1, 2, seconds=60.0), asks=False)
    guided.run(guided.done(1))
    guided.hands("place 2 8 35 0 0")
    began = guided.source.device.imu.time + 8
    view = guided.run(lambda v: any("heading is wrong" in event.text for event in v.events), seconds=60)
    assert 15 < guided.source.device.imu.time - began < 35
    turned = float(view.events[-1].text.split("turn ")[1].split()[0])
    assert view.events[-1].text.startswith("X points up is correct, but the heading is wrong: turn ")
    assert abs(turned - 35) < 8
    assert view.hint == view.events[-1].text
    guided.rest(30)
    assert sum("heading is wrong" in text for text in guided.texts) == 1
    guided.hands("place 2 8")
    guided.run(guided.done(2))
    assert "heading is wrong" not in guided.view.hint


def test_the_second_turn_of_an_axis_is_followed_all_the_way_round(rig: Make) -> None:
    guided = rig([Dwell(1, 10.0), Turn("x", "+", 3, 1, 5.0), Turn("x", "-", 3, 1, 5.0)])
    guided.run(guided.done(1))
    for count, direction in enumerate("+-", start=2):
        guided.run(lambda v: v.turn is not None and not v.turn.is_to_rest)
        guided.seen.clear()
        guided.hands(f"turn x {direction} 3 2")
        guided.run(guided.done(count))
    stds = [view.pose.heading_std_deg for view in guided.seen]
    assert all(std is not None and std < 12 for std in stds)
    assert off_deg(guided.view.pose, 1) < 8


def placed_7_turned(rig: Make, **how: bool) -> GuideRig:
    guided = rig(dwells(1, 2, 3, 4, 5, 6, 7, 8, seconds=40.0), **how)
    for count, position in enumerate((1, 2, 3, 4, 5, 6), start=1):
        guided.hands(f"place {position} 8")
        guided.run(guided.done(count))
    guided.hands("place 7 8 0 4 0")  # y is down: clockwise from above
    return guided


def test_a_position_that_stood_4_deg_off_is_named_at_once_and_done_again(rig: Make) -> None:
    guided = placed_7_turned(rig)
    view = guided.run(lambda v: v.question is not None)
    shown = re.match(
        r"Position 7 has a heading error of (\d\.\d) deg, clockwise from above, by the Earth rate",
        view.question.text,
    )
    assert shown
    assert float(shown[1]) == pytest.approx(4.0, abs=1.0)
    assert view.done == 7
    guided.execute("answer", key="r")
    guided.run(lambda v: v.stage == "place" and "set position 7 along the marks" in v.hint)
    guided.rest(20)
    assert guided.view.step("dwell_07").attempts == 1  # not where it stands
    guided.hands("place 7 8")
    guided.run(lambda v: v.step("dwell_07").attempts == 2)
    assert guided.rest(20).question is None
    assert guided.view.wanted == "dwell_08"
