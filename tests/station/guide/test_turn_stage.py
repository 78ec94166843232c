"""Hand turns: counted live, accepted when they come back, refused with a reason, judged by the seat."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Turn
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.guide.checks.seating import FIRST_ON_FACE
from station.guide.view import CalibrationView
from tests.refusals import refused
from tests.station.guide.rig import GuideRig

Make = Callable[..., GuideRig]
PLUS, MINUS = Turn("x", "+", 3, 1, 5.0), Turn("x", "-", 3, 1, 5.0)


def ready(view: CalibrationView) -> bool:
    return view.turn is not None and view.turn.rest_s >= view.turn.rest_wanted_s and not view.hint


def rejected(view: CalibrationView) -> bool:
    return any(event.sound == "rejected" for event in view.events)


def test_a_turn_has_rest_at_both_ends_and_three_revolutions_between(rig: Make) -> None:
    guided = rig([PLUS])
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(1))
    [turn] = read_campaign(guided.folder).campaign.turns
    k = guided.truth.gyro_k[0]
    assert abs(turn.series.gyro[:, 0].sum() / k - 1080) < 1
    for end in (turn.series.gyro[:200, 0], turn.series.gyro[-200:, 0]):  # 4 s
        assert abs(end.sum() / k) < 0.1


def test_the_counter_runs_with_the_turn_and_ends_at_the_revolutions_asked_for(rig: Make) -> None:
    guided = rig([Dwell(1, 20.0), Dwell(2, 20.0), MINUS])
    guided.run(guided.done(1))
    guided.hands("place 2 8")
    guided.run(guided.done(2))
    guided.hands("place 1 8")
    guided.run(ready)
    guided.hands("turn x - 3 2")
    guided.run(guided.done(3))
    turning = [view.turn for view in guided.seen if view.turn is not None]
    counted = [turn.revolutions for turn in turning]
    assert min(counted) == pytest.approx(-3.0, rel=0.05)  # the Earth's rate tells the scale to a few per cent
    assert 20 < max(turn.speed_deg_s for turn in turning) < 100
    assert "turn X-: 2." in " ".join(view.line for view in guided.seen)


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("turn x - 3 2", "wrong direction, expected counter-clockwise seen from above"),
        ("turn x + 2 2", "it was 2.00 revolutions, by the turns before it, expected 3"),
        ("place 5 8", "the cube was tipped over"),
        ("place 2 8", "wrong direction, expected counter-clockwise seen from above"),
    ],
)
def test_a_turn_that_is_not_the_one_asked_for_is_rejected_with_its_reason(
    rig: Make, command: str, reason: str
) -> None:
    guided = rig([MINUS, PLUS])
    guided.run(ready)
    guided.hands("turn x - 3 2")
    guided.run(guided.done(1))
    guided.run(lambda v: ready(v) and v.live == "turn_x_plus")
    guided.hands(command)
    view = guided.run(rejected)
    assert view.events[-1].text.startswith(f"turn X+: {reason}")
    assert view.events[-1].text.endswith("; repeat")
    guided.hands("place 1 8")
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(2))


def test_a_turn_in_which_samples_were_lost_is_done_again(rig: Make) -> None:
    guided = rig([PLUS], faults=[Fault("lost", at_s=25.0, count=2)])
    guided.run(ready)
    guided.hands("turn x + 3 2")
    view = guided.run(rejected)
    assert "samples were lost while it turned" in view.events[-1].text


def test_a_turn_from_the_other_position_of_its_face_is_refused(rig: Make) -> None:
    guided = rig([PLUS])
    guided.hands("place 2 8")
    view = guided.run(rejected)
    assert "position 2" in view.events[-1].text
    assert view.events[-1].text.endswith("in position 1")


@pytest.mark.parametrize("revolutions", [2, 4])
def test_the_first_turn_is_counted_by_the_earth_rate(rig: Make, revolutions: int) -> None:
    guided = rig([Dwell(1, 20.0), PLUS])
    guided.run(guided.done(1))
    guided.run(ready)
    guided.hands(f"turn x + {revolutions} 2")
    view = guided.run(rejected)
    assert re.search(r"about \d\.\d revolutions were made, expected 3", view.events[-1].text)
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(2))


def test_a_turn_the_wrong_way_stops_at_once_where_nothing_else_is_to_be_done_that_way(rig: Make) -> None:
    guided = rig([PLUS])
    guided.run(ready)
    guided.hands("turn x - 3 2")
    began = guided.source.device.imu.time
    view = guided.run(rejected)
    assert guided.source.device.imu.time < began + 15  # of about 35
    assert view.events[-1].text == ("turn X+: wrong direction, expected counter-clockwise seen from above; repeat")
    assert max((v.turn.revolutions for v in guided.seen if v.turn is not None), default=0.0) < 0.1


@pytest.mark.parametrize("position", [3, 8])
def test_a_cube_that_is_tipped_over_is_no_turn_the_wrong_way(rig: Make, position: int) -> None:
    guided = rig([PLUS])
    guided.run(ready)
    guided.hands(f"place {position} 8")
    assert "the cube was tipped over" in guided.run(rejected).events[-1].text


@pytest.mark.parametrize("when", ["while it turns", "after it"])
def test_a_turn_the_wrong_way_is_taken_as_the_other_one_if_the_operator_says_so(rig: Make, when: str) -> None:
    guided = rig([PLUS, MINUS])
    guided.run(ready)
    guided.hands("turn x - 3 2")
    view = guided.run(lambda v: v.question is not None)
    assert view.hint.startswith("wrong direction")
    assert "that is turn X-; requested is turn X+" in view.question.text
    if when == "after it":
        guided.rest(90)
        assert guided.view.done == 0
    guided.execute("answer", key="y")
    view = guided.run(guided.done(1))
    assert view.step("turn_x_minus").attempts == 1
    assert view.wanted == "turn_x_plus"
    [turn] = read_campaign(guided.folder).campaign.turns
    assert turn.direction == "-"
    assert turn.series.gyro[:, 0].sum() < 0


def turn(guided: GuideRig, direction: str) -> None:
    before = guided.recorder.accepted.total()
    guided.run(lambda v: ready(v) and v.live.endswith({"+": "plus", "-": "minus"}[direction]))
    guided.hands(f"turn x {direction} 3 2")
    guided.run(lambda _: guided.recorder.accepted.total() > before)


def off_by(guided: GuideRig, direction: str, degrees: float) -> None:
    """Turn, and end off the mark: the cube creeps on in the last moment of the turn."""
    before = guided.recorder.accepted.total()
    guided.run(lambda v: ready(v) and v.live.endswith({"+": "plus", "-": "minus"}[direction]))
    guided.hands(f"turn x {direction} 3 0")
    guided.hands(f"creep 1 {degrees if direction == '+' else -degrees} 0 0")
    guided.run(lambda _: guided.recorder.accepted.total() > before)


def test_a_pair_that_did_not_close_is_not_taken_and_a_third_turn_decides(rig: Make) -> None:
    guided = rig([PLUS, MINUS])
    turn(guided, "+")
    off_by(guided, "-", 0.5)
    text = guided.texts[-1]
    assert re.match(r"rejected: turn X- and turn X\+ differ by 0\.\d\d deg, limit 0\.05: one more turn X-", text)
    assert not guided.guide.is_complete
    view = guided.run(lambda v: v.question is not None)
    assert [choice.key for choice in view.question.choices] == ["t", "w"]
    turn(guided, "-")  # no answer is needed to turn
    assert guided.guide.is_complete
    assert [t.name for t in read_campaign(guided.folder).campaign.turns] == [
        "turn_x_plus.mcap",
        "turn_x_minus_2.mcap",
    ]


def test_where_the_third_turn_confirms_the_second_the_first_is_done_again(rig: Make) -> None:
    guided = rig([PLUS, MINUS])
    off_by(guided, "+", 0.5)
    turn(guided, "-")
    turn(guided, "-")
    assert guided.texts[-1].endswith("turn X- is confirmed, repeat turn X+")
    turn(guided, "+")
    assert guided.guide.is_complete


def test_a_pair_that_did_not_close_is_known_after_a_resume(rig: Make) -> None:
    guided = rig([PLUS, MINUS])
    turn(guided, "+")
    off_by(guided, "-", 0.5)
    guided.resume()
    assert guided.view.wanted == "turn_x_minus"
    assert guided.view.step("turn_x_minus").state == "redo"
    guided.hands("place 1 8")
    turn(guided, "-")
    assert guided.guide.is_complete
    guided.resume()
    assert guided.guide.is_complete


def test_the_operator_may_state_a_wider_closure_which_is_recorded_as_that_act(rig: Make) -> None:
    guided = rig([PLUS, MINUS])
    turn(guided, "+")
    off_by(guided, "-", 0.5)
    guided.run(lambda v: v.question is not None)
    guided.execute("answer", key="w")
    guided.run(lambda _: guided.guide.is_complete)
    loaded = read_campaign(guided.folder)
    stated = loaded.tables.procedure
    assert stated.closure_widened_from_deg == pytest.approx(np.degrees(2e-4), rel=1e-6)
    assert 0.2 < stated.closure_std_deg < 0.6
    assert np.degrees(loaded.campaign.sigma.closure) == pytest.approx(stated.closure_std_deg)
    assert any("increased by the operator" in warning for warning in loaded.warnings)


def test_with_nobody_to_ask_turns_that_never_agree_end_honestly(rig: Make) -> None:
    guided = rig([PLUS, MINUS], asks=False)

    def turn_until_refused() -> None:
        for off in (0.1, 0.4, 0.8, -0.3, 0.2, 0.6, 1.0, -0.7):
            off_by(guided, guided.view.step(guided.view.wanted).direction, off)

    with refused(DataRefused, ErrorCode.PROCEDURE):
        turn_until_refused()
    assert guided.recorder.accepted.total() in {6, 7}


ONCE = Turn("x", "+", 1, 1, 5.0)
FINE = replace(Truth.example(2), accel_k=np.full(3, 1e5))
PAIR = [Dwell(1, 20.0), Dwell(2, 20.0)]
OTHERS = [Dwell(position, 10.0) for position in (3, 5, 7)]


def was_reported(guided: GuideRig, what: str) -> bool:
    return any(what in text for text in guided.texts)


def placed(guided: GuideRig, *positions: int, off: str = "") -> None:
    for position in positions:
        guided.hands(f"place {position} 8 {off}".strip())
        guided.run(guided.done(guided.view.done + 1))


def turned(guided: GuideRig, command: str = "turn x + 1 2") -> None:
    guided.run(lambda v: v.turn is not None and v.turn.may_begin)
    guided.hands(command)


def test_debris_is_reported_before_the_turn(rig: Make) -> None:
    guided = rig([*PAIR, ONCE], FINE)
    guided.run(guided.done(1))
    placed(guided, 2)
    guided.hands("place 1 8 0 0.12 0")
    guided.run(lambda _: was_reported(guided, "not seated: tilted by 4"))
    assert not guided.view.gates.is_seated
    guided.hands("place 1 8")
    turned(guided)
    guided.run(guided.done(3))
    assert not was_reported(guided, "turn again")


def test_a_cube_that_came_to_lie_on_something_as_it_was_turned_is_turned_again(rig: Make) -> None:
    guided = rig([ONCE], FINE)
    turned(guided)
    guided.hands("creep 3 0 0.05 0")
    guided.run(lambda _: was_reported(guided, "turn X+: the cube is tilted by 18") or guided.view.done > 0)
    assert guided.view.done == 0
    guided.hands("place 1 8")
    turned(guided)
    guided.run(guided.done(1))


@pytest.mark.parametrize("is_resumed", [False, True])
def test_a_turn_before_any_dwell_is_judged_by_the_first_on_its_face(rig: Make, *, is_resumed: bool) -> None:
    guided = rig([ONCE, *PAIR], FINE)
    guided.hands("place 1 8 0 0.12 0")
    guided.run(lambda v: v.gates is not None and v.gates.seating == FIRST_ON_FACE)
    turned(guided)
    guided.run(guided.done(1))
    if is_resumed:
        guided.resume()
    placed(guided, 2, 1)  # one of the two alone may be the slab
    guided.run(lambda _: was_reported(guided, "turn X+: the cube was tilted by 4"))
    assert guided.view.wanted == "turn_x_plus"
    guided.hands("place 1 8")
    turned(guided)
    guided.run(lambda v: v.step("turn_x_plus").attempts == 2)
    assert [table.turn_on for table in read_campaign_toml(guided.folder)[0].turn] == [None]


def test_a_turn_after_a_restart_is_judged_by_dwells_of_before_and_since(rig: Make) -> None:
    """The unit's biases stepped by 1 mg, which looks like 206 arcsec: only together they tell a crumb."""
    stepping = replace(FINE, accel_turn_on_g=1e-3)
    guided = rig([*PAIR, *OTHERS, ONCE, Dwell(3, 10.0, 1)], stepping, faults=[Fault("restart", 200.0, seconds=2)])
    guided.run(guided.done(1))
    placed(guided, 2, 3, 5, 7)
    guided.run(lambda _: was_reported(guided, "switched off and on"))
    guided.hands("place 1 8 0 0.12 0")
    turned(guided)
    guided.run(guided.done(6))
    placed(guided, 3)
    guided.run(lambda _: was_reported(guided, "turn X+: the cube was tilted by 4"))
