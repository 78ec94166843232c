"""One instruction at a time: what the top of the screen says is the one thing to do."""

import pytest

from station.guide.view import CalibrationView, StepView, TurnView
from station.tui.orientation import is_counter_clockwise
from tests.station.tui import views
from tests.station.tui.session import screens
from tests.station.tui.test_messages import said_in


@pytest.mark.parametrize(
    ("view", "said", "not_said"),
    [
        (views.PLACING, "NOW put the cube in position 3", "hands off"),
        (views.SETTLING, "KEEP STILL hands off", "put the cube"),
        (views.BADLY_SEATED, "SET DOWN AGAIN lift the cube, wipe it and the slab", "position"),
        (views.TURNING, "TURN turn X-: 2.34 of 3 turns", "hands off"),
        (views.CAME_BACK, "KEEP STILL hands off: it rests after turn X-", "3 times"),
        (views.SILENT, "NO DATA check cable and power", "position"),
        (views.OTHER_UNIT, "WRONG UNIT connect the campaign's own unit", "NO DATA"),
        (views.WARMING, "WARM-UP leave the cube at rest", "put the cube"),
    ],
)
async def test_the_banner_says_one_thing(view: CalibrationView, said: str, not_said: str) -> None:
    async with screens(view) as seen:
        await seen.pilot.pause()
        banner = said_in(seen, seen.app.screen.banner)
        assert said in banner
        assert not_said not in banner


@pytest.mark.parametrize("step", [step for step in views.steps(12) if step.axis], ids=lambda step: step.name)
async def test_symbol_and_column_of_a_turn_are_those_of_the_turn_asked_for(step: StepView) -> None:
    turn = TurnView(revolutions=1.0, speed_deg_s=30.0)
    view = views.TURNING.model_copy(update={"live": step.name, "wanted": step.name, "turn": turn})
    async with screens(view) as seen:
        await seen.pilot.pause()
        symbol = "↺" if is_counter_clockwise(step) else "↻"
        assert f"{symbol} TURN" in said_in(seen, seen.app.screen.banner)
        rows = seen.app.screen.grid.render().plain.split("\n")
        at = next(i for i, row in enumerate(rows) if "turn X, X up" in row)
        cell = f"▶{symbol} {step.axis.upper()}{step.direction}"
        assert cell in rows[at + 1]
        column = rows[at].index(f"turn {step.axis.upper()}, {step.axis.upper()} up")
        assert column - 2 <= rows[at + 1].index(cell) < column + 12  # below the heading of its own axis


async def test_a_warm_up_shows_numbers_that_a_person_reads() -> None:
    async with screens(views.WARMING) as seen:
        await seen.pilot.pause()
        said = " ".join(" ".join(seen.lines()).split())
        assert "0.000 < 0.029 deg/h" in said
        assert "0.210 > 0.050 °C/min" in said
        assert "e-" not in said
        assert "waiting for a temperature rate below 0.050 °C/min, now 0.210 °C/min" in said
