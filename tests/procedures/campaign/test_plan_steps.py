from procedures.campaign.plan_steps import Dwell, Turn, dwell_steps, turn_steps
from procedures.frames import TURN_START


def test_a_plan_asks_for_twelve_dwells_in_order() -> None:
    assert dwell_steps(60.0) == tuple(Dwell(p, 60.0) for p in range(1, 13))


def test_a_plan_asks_for_both_directions_about_every_axis() -> None:
    assert turn_steps(3, 5.0) == tuple(Turn(a, d, 3, TURN_START[a], 5.0) for a in "xyz" for d in "+-")
