"""A position that stood turned against the marks: said as soon as it shows, and done again."""

import re
from collections.abc import Callable

import pytest

from tests.station.guide.rig import GuideRig, dwells

Make = Callable[..., GuideRig]


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
    told = re.match(
        r"Position 7 stood (\d\.\d) deg off, clockwise from above, by the Earth rate", view.question.text
    )
    assert told
    assert float(told[1]) == pytest.approx(4.0, abs=1.0)
    assert view.done == 7
    guided.obey("answer", key="r")
    guided.run(lambda v: v.stage == "place" and "set position 7 along the marks" in v.hint)
    guided.rest(20)
    assert guided.view.step("dwell_07").attempts == 1  # not where it stands
    guided.hands("place 7 8")
    guided.run(lambda v: v.step("dwell_07").attempts == 2)
    assert guided.rest(20).question is None
    assert guided.view.wanted == "dwell_08"


def test_with_nobody_to_ask_it_is_done_again_once(rig: Make) -> None:
    guided = placed_7_turned(rig, asks=False)
    guided.run(lambda v: v.step("dwell_07").state == "redo")
    guided.hands("place 7 8 0 4 0")
    guided.run(lambda v: v.step("dwell_07").attempts == 2)
    assert guided.view.wanted == "dwell_08"
