"""The keys of the campaign screen, and the commands they send."""

import pytest

from station.guide.view import CalibrationView, OperatorCommand
from station.tui.screens.modals import ConfirmScreen
from station.tui.widgets.step_grid import GridCursor
from tests.station.tui import views
from tests.station.tui.session import LARGE, screens

PLACE = views.PLACEMENT  # wanted: dwell_03; done: dwell_01, dwell_02


@pytest.mark.parametrize(
    ("view", "keys", "command"),
    [
        (PLACE, "p", OperatorCommand(verb="pause")),
        (views.PAUSED, "p", OperatorCommand(verb="go_on")),
        (PLACE, "r", OperatorCommand(verb="redo", step="dwell_02")),  # the cursor is on a step not done yet
        (PLACE, "b b r", OperatorCommand(verb="redo", step="dwell_01")),
        (PLACE, "left r", OperatorCommand(verb="redo", step="dwell_01")),
        (PLACE, "enter", OperatorCommand(verb="choose", step="dwell_03")),
        (PLACE, "right enter", OperatorCommand(verb="choose", step="dwell_05")),
        (PLACE, "down enter", OperatorCommand(verb="choose", step="dwell_04")),
        (PLACE, "up left enter", OperatorCommand(verb="choose", step="turn_x_plus")),
        (PLACE, "right escape enter", OperatorCommand(verb="choose", step="dwell_03")),
        (views.BADLY_SEATED, "k", OperatorCommand(verb="keep_seating")),
        (views.TURNING, "f y", OperatorCommand(verb="finish")),
        (views.WARMING, "s y", OperatorCommand(verb="skip_warm_up")),
        (views.PASSED, "s y", OperatorCommand(verb="store")),
    ],
)
async def test_a_key_sends_its_command(view: CalibrationView, keys: str, command: OperatorCommand) -> None:
    async with screens(view) as seen:
        await seen.press(*keys.split())
        assert seen.sent == [command]


@pytest.mark.parametrize(
    ("view", "keys"),
    [
        (PLACE, "k"),  # it sits well
        (views.running("place", steps=views.steps(0), wanted="dwell_01", can_redo=""), "r"),
        (views.running("place", steps=views.steps(0), wanted="dwell_01", can_redo=""), "f"),
        (views.TURNING, "f n"),
        (views.WARMING, "s escape"),
        (views.PASSED, "d s escape"),  # a diagnosis is read, nothing is stored from there
        (views.STORED, "s"),
        (views.STORED, "c"),
    ],
)
async def test_what_makes_no_sense_or_was_not_confirmed_sends_nothing(view: CalibrationView, keys: str) -> None:
    async with screens(view) as seen:
        await seen.press(*keys.split())
        assert seen.sent == []
        assert not isinstance(seen.app.screen, ConfirmScreen)


async def test_the_cursor_goes_with_the_step_wanted_until_it_is_moved() -> None:
    async with screens(PLACE) as seen:
        grid = seen.app.screen.grid
        assert grid.value.cursor == "dwell_03"
        await seen.press("right")
        await seen.show(views.BADLY_SEATED)
        assert (grid.value.wanted, grid.value.cursor) == ("dwell_04", "dwell_05")
        await seen.press("escape")
        assert grid.value.cursor == "dwell_04"


@pytest.mark.parametrize("key", ["up", "down", "left", "right"])
def test_the_cursor_reaches_every_step_of_its_line_and_comes_round(key: str) -> None:
    down, right = {"up": (-1, 0), "down": (1, 0), "left": (0, -1), "right": (0, 1)}[key]
    grid = GridCursor(views.steps(0), cursor="dwell_01")
    seen = []
    for _ in range(6 if right else 3):
        grid = GridCursor(grid.steps, cursor=grid.neighbour(down, right))
        seen.append(grid.cursor)
    assert seen[-1] == "dwell_01"
    assert len(set(seen)) == (6 if right else 3)


async def test_gates_and_turn_say_word_symbol_and_number() -> None:
    async with screens(views.PLACEMENT, LARGE) as seen:
        face, still = seen.app.screen.gates.render().plain.split("\n")
        assert "✗ tilted" in face
        assert "Y up, 40.0 > 3 deg" in face
        assert "✗ moving" in still
        assert "38.2 > 4 noise gyro z" in still
        await seen.show(views.TURNING)
        turns, speed, rest = seen.app.screen.turn.render().plain.split("\n")
        assert "2.34 of 3" in turns
        assert "✓ good" in speed
        assert "0 of 5 s" in rest
        assert seen.app.screen.turn.display
        for rate, word in ((0.2, "at rest"), (3.0, "faster"), (-120.0, "slower")):
            turn = views.TURNING.turn.model_copy(update={"speed_deg_s": rate})
            await seen.show(views.TURNING.model_copy(update={"turn": turn}))
            assert word in seen.app.screen.turn.render().plain


async def test_to_finish_what_cannot_be_solved_is_refused_before_it_is_asked() -> None:
    async with screens(PLACE) as seen:
        await seen.press("f", "y")
        await seen.pilot.pause()
        assert seen.sent == []
        assert not isinstance(seen.app.screen, ConfirmScreen)
        assert any("Not enough steps to solve" in line for line in seen.lines())
