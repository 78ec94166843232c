"""The cube as it stands: followed from the counts of a simulated device while hands carry it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.errors import LinkSilent
from drivers.simulated.line_faults import Fault
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.frames import nominal_C_lb
from station.guide.view import CalibrationView, PoseView
from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


def off_deg(pose: PoseView, position: int) -> float:
    """Return the angle between an attitude and a position's."""
    between = np.array(pose.C_lb).T @ nominal_C_lb(position)
    return float(np.degrees(np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1))))


def known_pose(view: CalibrationView) -> bool:
    return view.pose is not None and view.pose.heading_std_deg is not None


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
    assert guided.view.pose.text == "it stands as wanted"


def test_a_wrong_face_is_said_with_the_way_to_tip_it(rig: Make) -> None:
    guided = rig(dwells(1, 5))
    view = guided.run(guided.done(1))  # X up, Y east: Y comes up by tipping it to the west
    assert view.pose.turn_deg is None
    assert view.pose.text == "tip it over to the west: Y up"


def test_before_anything_told_the_heading_it_is_said_to_be_unknown(rig: Make) -> None:
    guided = rig(dwells(1), replace(Truth.example(1), latitude_deg=89.9))
    view = guided.rest(12)
    assert view.pose.heading_std_deg is None
    assert view.pose.turn_deg is None
    assert view.pose.text == "which way it points is not known yet"


def test_what_the_operator_said_is_the_heading_where_the_earth_does_not_tell(rig: Make) -> None:
    guided = rig(dwells(1, 2), replace(Truth.example(1), latitude_deg=89.9))
    guided.run(lambda v: v.question is not None)
    guided.obey("answer", key="1")
    view = guided.run(guided.done(1))
    view = guided.rest(2)
    assert view.pose.heading_std_deg == pytest.approx(2.0, abs=0.2)
    assert off_deg(view.pose, 1) < 3


def test_a_heading_that_stays_wrong_on_the_right_face_is_said_after_20_s_and_once(rig: Make) -> None:
    guided = rig(dwells(1, 2, seconds=60.0), asks=False)
    guided.run(guided.done(1))
    guided.hands("place 2 8 35 0 0")
    began = guided.source.device.imu.time + 8
    view = guided.run(lambda v: any("heading is wrong" in event.text for event in v.events), seconds=60)
    assert 15 < guided.source.device.imu.time - began < 35
    turned = float(view.events[-1].text.split("turn ")[1].split()[0])
    assert view.events[-1].text.startswith("X points up as wanted, but the heading is wrong: turn ")
    assert abs(turned - 35) < 8
    assert view.hint == view.events[-1].text
    guided.rest(30)
    assert sum("heading is wrong" in text for text in guided.texts) == 1
    guided.hands("place 2 8")
    guided.run(guided.done(2))
    assert "heading is wrong" not in guided.view.hint


def test_what_was_said_before_a_restart_is_no_heading_after_it(rig: Make) -> None:
    truth = replace(Truth.example(1), latitude_deg=89.9)
    guided = rig(dwells(1, 2, seconds=20.0), truth, faults=[Fault("restart", at_s=60.0, seconds=5.0)])
    guided.run(lambda v: v.question is not None)
    guided.obey("answer", key="1")
    guided.run(guided.done(1))
    guided.run(known_pose)
    guided.run(lambda v: v.pose is not None and v.pose.heading_std_deg is None)


def test_nothing_is_shown_of_cube_and_gates_while_the_stream_is_silent(rig: Make) -> None:
    guided = rig(dwells(1))
    guided.rest(8)
    guided.guide.stream_failed(LinkSilent("imu", 1.8, None))
    view = guided.view
    assert (view.gates, view.pose) == (None, None)
    assert view.link.word == "NO DATA"
    assert view.line == "check cable and power; it goes on by itself"


def test_a_view_with_a_pose_crosses_a_process_border_unchanged(rig: Make) -> None:
    guided = rig([Dwell(1, 10.0), Turn("x", "+", 3, 1, 5.0)])
    view = guided.run(guided.done(1))
    assert CalibrationView.model_validate_json(view.model_dump_json()) == view


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


def test_a_turn_may_not_begin_before_its_rest(rig: Make) -> None:
    guided = rig([Turn("x", "+", 1, 1, 5.0)])
    guided.run(lambda v: v.turn is not None and not v.turn.is_to_rest)
    before = [view for view in guided.seen if view.turn is not None and view.turn.is_to_rest]
    assert len({view.line for view in before}) == 1
    assert guided.view.line.startswith("turn once counter-clockwise from above")


def test_the_gate_tells_the_face_wanted_from_another_that_is_to_do_and_from_one_that_is_done(rig: Make) -> None:
    guided = rig(dwells(1, 5, seconds=20.0))
    guided.run(lambda v: v.stage == "dwell" and v.gates is not None)
    assert (guided.view.gates.is_right_face, guided.view.gates.is_wanted_face) == (True, True)
    guided.run(guided.done(1))
    gates = guided.view.gates
    assert (gates.face, gates.is_right_face, gates.is_wanted_face) == ("x_up", False, False)
    guided.obey("redo", step="dwell_01")
    gates = guided.view.gates
    assert (gates.is_right_face, gates.is_wanted_face) == (True, True)
    guided.hands("place 5 8")
    guided.run(
        lambda v: v.gates is not None and v.gates.face == "y_up" and v.gates.off_deg < 1 and v.stage != "dwell"
    )
    gates = guided.view.gates
    assert (gates.is_right_face, gates.is_wanted_face) == (True, False)
