"""The technician's page and glossary name every key, sign and word of the screens; its pictures are there."""

import re

import pytest
from textual.binding import Binding

from station.guide.stages.guide import trouble_of
from station.tui.app import StationApp
from station.tui.screens import SCREENS, screen_for
from station.tui.screens.campaign import STAGE_LOOKS
from station.tui.screens.framed_screen import NO_DATA
from station.tui.widgets.step_grid import STEP_LOOKS
from tests.paths import ROOT
from tests.station.tui import views
from tests.station.tui.screenshots import PICTURES, picture
from tests.station.tui.session import screens
from tests.station.tui.test_messages import STREAM

DOCS = ROOT / "docs"
PAGE = (DOCS / "how-to/guided-calibration.md").read_text(encoding="utf-8")
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


GLOSSARY = (ROOT / "docs/reference/glossary.md").read_text(encoding="utf-8")
WORDS = [word.strip() for row in re.findall(r"^\| (.+?) \|", GLOSSARY, re.MULTILINE) for word in row.split(",")]
SHOUTED = re.compile(r"(?<![\w/+-])[A-Z]{2,}(?:[ -][A-Z]{2,})*(?![\w-])")
NAMES = {"SIM", "FOG", "IMU", "IMUS", "SLAB", "CUBE", "GNSS", "FTDI", "USB", "PASS", "FAIL", "CANCELLED", "LEFT"}


def test_the_words_of_banner_link_and_steps_are_explained() -> None:
    shown = {word for word, _, _ in STAGE_LOOKS.values()} | set(STEP_LOOKS) | {NO_DATA, "SET DOWN AGAIN", "live"}
    shown |= {trouble_of(error)[0] for error in STREAM}
    assert shown - set(WORDS) == set()


async def test_every_word_in_capitals_that_stands_on_a_screen_of_the_campaign_is_explained() -> None:
    missing = dict[str, str]()
    async with screens(views.CONNECTING) as seen:
        for name, view in views.VIEWS.items():
            if view.question or view.stage in {"start", "cancelled", "left", "failed"}:
                continue
            await seen.show(view)
            await seen.pilot.pause()
            for line in seen.lines()[1:]:  # the first names unit and campaign
                missing |= {word: name for word in SHOUTED.findall(line) if word not in {*WORDS, *NAMES}}
    assert missing == {}
