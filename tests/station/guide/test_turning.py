"""Hand turns: counted live, accepted when they come back, refused with a reason."""

import re
from collections.abc import Callable
from dataclasses import replace

import pytest

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from procedures.steps import Dwell, Turn
from station.campaign_folder import read_campaign
from station.guide.view import View
from tests.station.guide.rig import GuideRig

Make = Callable[..., GuideRig]
PLUS, MINUS = Turn("x", "+", 3, 1, 5.0), Turn("x", "-", 3, 1, 5.0)


def ready(view: View) -> bool:
    return view.turn is not None and view.turn.rest_s >= view.turn.rest_wanted_s and not view.hint


def rejected(view: View) -> bool:
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


def test_the_second_turn_of_a_pair_says_how_well_both_closed(rig: Make) -> None:
    guided = rig([PLUS, MINUS])
    for count, direction in enumerate("+-", start=1):
        guided.run(lambda v, d=direction: ready(v) and v.live.endswith({"+": "plus", "-": "minus"}[d]))
        guided.hands(f"turn x {direction} 3 2")
        guided.run(guided.done(count))
    first, second = (step.note for step in guided.view.steps)
    assert re.fullmatch(r"came back within \d\.\d\d deg \(1 sigma \d\.\d\d\)", first)
    assert float(second.split()[3]) < 0.15  # closures are 0.01 deg, 1 sigma


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("turn x - 3 2", "it was the other way round, expected counter-clockwise seen from above"),
        ("turn x + 2 2", "it was 2.00 revolutions, by the turns before it, expected 3"),
        ("place 5 8", "the cube was tipped over"),
        ("place 2 8", "it was"),
    ],
)
def test_a_turn_that_is_not_the_one_asked_for_is_told_why(rig: Make, command: str, reason: str) -> None:
    guided = rig([MINUS, PLUS])
    guided.run(ready)
    guided.hands("turn x - 3 2")
    guided.run(guided.done(1))
    guided.run(lambda v: ready(v) and v.live == "turn_x_plus")
    guided.hands(command)
    view = guided.run(rejected)
    assert view.events[-1].text.startswith(f"turn X+: {reason}")
    assert view.events[-1].text.endswith("; once more")
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
    assert view.events[-1].text == "the cube stands in position 2; a turn X+ begins in position 1"


def test_it_is_asked_where_a_turn_begins_if_the_earth_rate_does_not_tell(rig: Make) -> None:
    guided = rig([PLUS], replace(Truth.example(1), latitude_deg=89.5))
    view = guided.run(lambda v: v.question is not None)
    assert [choice.key for choice in view.question.choices] == ["1", "2", "n"]
    guided.obey("answer", key="1")
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(1))


def test_a_pause_in_mid_turn_lets_it_be_done_again(rig: Make) -> None:
    guided = rig([PLUS])
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.rest(10)
    guided.obey("pause")
    guided.rest(60)
    assert guided.view.done == 0
    guided.obey("go_on")
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(1))


@pytest.mark.parametrize("revolutions", [2, 4])
def test_the_first_turn_is_counted_by_the_earth_rate(rig: Make, revolutions: int) -> None:
    guided = rig([Dwell(1, 20.0), PLUS])
    guided.run(guided.done(1))
    guided.run(ready)
    guided.hands(f"turn x + {revolutions} 2")
    view = guided.run(rejected)
    assert re.search(r"it was about \d\.\d revolutions, expected 3", view.events[-1].text)
    guided.run(ready)
    guided.hands("turn x + 3 2")
    guided.run(guided.done(2))


def test_a_turn_the_wrong_way_is_told_while_it_turns(rig: Make) -> None:
    guided = rig([PLUS])
    guided.run(ready)
    guided.hands("turn x - 3 2")
    guided.run(lambda v: v.hint == "the other way round: counter-clockwise seen from above")
