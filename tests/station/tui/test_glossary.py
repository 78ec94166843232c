"""Every word that the screens show in capitals, and every state of a step, is explained in the glossary."""

import re

from station.guide.guide import trouble_of
from station.tui.screens.campaign import STAGE_LOOKS
from station.tui.screens.framed import NO_DATA
from station.tui.widgets.step_grid import STEP_LOOKS
from tests.paths import ROOT
from tests.station.tui import views
from tests.station.tui.session import screens
from tests.station.tui.test_messages import STREAM

PAGE = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
WORDS = [word.strip() for row in re.findall(r"^\| (.+?) \|", PAGE, re.MULTILINE) for word in row.split(",")]
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
