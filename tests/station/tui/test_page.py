"""The technician's page names every key, sound and sign of the screens, and its pictures are there."""

import pytest
from textual.binding import Binding

from station.tui.app import StationApp
from station.tui.screens import SCREENS, screen_for
from station.tui.screens.campaign import STAGE_LOOKS
from station.tui.widgets.step_grid import STEP_LOOKS
from tests.paths import ROOT
from tests.station.tui.screenshots import PICTURES, picture

DOCS = ROOT / "docs"
PAGE = (DOCS / "guided-calibration.md").read_text(encoding="utf-8")
SHOWN = {"down": "arrows", "enter": "Enter", "question_mark": "`?`", "escape": "Esc"}


def test_the_page_names_every_key() -> None:
    bindings = [b for screen in {*map(screen_for, SCREENS), StationApp} for b in screen.BINDINGS]
    keys = {b.key.split(",")[0] for b in bindings if isinstance(b, Binding) and b.show}
    assert len(keys) > 12
    for key in keys:
        assert SHOWN.get(key, f"`{key}`") in PAGE, key


def test_the_page_names_every_state_of_a_step() -> None:
    assert all(f"`{symbol} {state}`" in PAGE for state, (symbol, _) in STEP_LOOKS.items())
    assert set(STAGE_LOOKS) == {"place", "settle", "dwell", "turn", "paused"}


@pytest.mark.parametrize("name", PICTURES)
async def test_each_picture_is_what_the_screens_show(name: str) -> None:
    assert f"screens/{name}.svg" in PAGE
    assert (DOCS / "screens" / f"{name}.svg").read_text(encoding="utf-8") == await picture(PICTURES[name]), (
        "draw it again: python -m tests.station.tui.screenshots"
    )
