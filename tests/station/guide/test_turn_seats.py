"""A cube that lies tilted as it is turned: told before the turn, after it, or once a dwell shows it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.line_faults import Fault
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Turn
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.guide.seating_watch import FIRST_ON_FACE
from tests.station.guide.rig import GuideRig

Make = Callable[..., GuideRig]
PLUS = Turn("x", "+", 1, 1, 5.0)
FINE = replace(Truth.example(2), accel_k=np.full(3, 1e5))
PAIR = [Dwell(1, 20.0), Dwell(2, 20.0)]
OTHERS = [Dwell(position, 10.0) for position in (3, 5, 7)]


def said(guided: GuideRig, what: str) -> bool:
    return any(what in text for text in guided.texts)


def placed(guided: GuideRig, *positions: int, off: str = "") -> None:
    for position in positions:
        guided.hands(f"place {position} 8 {off}".strip())
        guided.run(guided.done(guided.view.done + 1))


def turned(guided: GuideRig, command: str = "turn x + 1 2") -> None:
    guided.run(lambda v: v.turn is not None and v.turn.may_begin)
    guided.hands(command)


def test_a_crumb_is_told_before_the_turn(rig: Make) -> None:
    guided = rig([*PAIR, PLUS], FINE)
    guided.run(guided.done(1))
    placed(guided, 2)
    guided.hands("place 1 8 0 0.12 0")
    guided.run(lambda _: said(guided, "not seated: tilted by 4"))
    assert not guided.view.gates.is_seated
    guided.hands("place 1 8")
    turned(guided)
    guided.run(guided.done(3))
    assert not said(guided, "turn again")


def test_a_cube_that_came_to_lie_on_something_as_it_was_turned_is_turned_again(rig: Make) -> None:
    guided = rig([PLUS], FINE)
    turned(guided)
    guided.hands("creep 3 0 0.05 0")
    guided.run(lambda _: said(guided, "turn X+: the cube lies tilted by 18") or guided.view.done > 0)
    assert guided.view.done == 0
    guided.hands("place 1 8")
    turned(guided)
    guided.run(guided.done(1))


@pytest.mark.parametrize("is_resumed", [False, True])
def test_a_turn_before_any_dwell_is_judged_by_the_first_on_its_face(rig: Make, *, is_resumed: bool) -> None:
    guided = rig([PLUS, *PAIR], FINE)
    guided.hands("place 1 8 0 0.12 0")
    guided.run(lambda v: v.gates is not None and v.gates.seating == FIRST_ON_FACE)
    turned(guided)
    guided.run(guided.done(1))
    if is_resumed:
        guided.resume()
    placed(guided, 2, 1)  # one of the two alone may be the slab
    guided.run(lambda _: said(guided, "turn X+: the cube was tilted by 4"))
    assert guided.view.wanted == "turn_x_plus"
    guided.hands("place 1 8")
    turned(guided)
    guided.run(lambda v: v.step("turn_x_plus").attempts == 2)
    assert [table.turn_on for table in read_campaign_toml(guided.folder)[0].turn] == [None]


def test_a_turn_after_a_restart_is_judged_by_dwells_of_before_and_since(rig: Make) -> None:
    """The unit's biases stepped by 1 mg, which looks like 206 arcsec: only together they tell a crumb."""
    stepping = replace(FINE, accel_turn_on_g=1e-3)
    guided = rig([*PAIR, *OTHERS, PLUS, Dwell(3, 10.0, 1)], stepping, faults=[Fault("restart", 200.0, seconds=2)])
    guided.run(guided.done(1))
    placed(guided, 2, 3, 5, 7)
    guided.run(lambda _: said(guided, "switched off and on"))
    guided.hands("place 1 8 0 0.12 0")
    turned(guided)
    guided.run(guided.done(6))
    placed(guided, 3)
    guided.run(lambda _: said(guided, "turn X+: the cube was tilted by 4"))
