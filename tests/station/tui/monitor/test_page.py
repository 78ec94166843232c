"""The monitor's page names every key, alarm and mode, and its pictures are what the screen shows."""

from typing import get_args

import pytest
from textual.binding import Binding

from station.attitude.live_readings import MotionState
from station.monitor.text_lines import MONITOR_KEYS
from station.monitor.view import ALARMS
from station.tui.monitor_screen import MonitorApp, MonitorScreen
from tests.paths import ROOT
from tests.station.tui.monitor.screenshots import PICTURES, picture

DOCS = ROOT / "docs"
PAGE = (DOCS / "how-to/monitor.md").read_text(encoding="utf-8")


def test_the_page_names_every_key() -> None:
    keys = {b.key for kind in (MonitorScreen, MonitorApp) for b in kind.BINDINGS if isinstance(b, Binding)}
    assert len(keys) == 8
    for key in keys:
        assert f"`{'?' if key == 'question_mark' else key}`" in PAGE, key
    assert set(MONITOR_KEYS) < keys


def test_the_page_names_every_alarm_and_mode() -> None:
    assert all(f"`{name}`" in PAGE for name in ALARMS)
    assert all(mode in PAGE for mode in get_args(MotionState))


@pytest.mark.parametrize("name", PICTURES)
async def test_each_picture_is_what_the_screen_shows(name: str) -> None:
    assert (DOCS / "screens" / f"{name}.svg").read_text(encoding="utf-8") == await picture(*PICTURES[name])
