"""The monitor's screen fits, says what matters, obeys keys, and looks as it did."""

from collections.abc import Callable

import pytest
from textual.widgets import Footer

from station.tui.monitor_screen import MonitorApp
from station.tui.screens.modals import ConfirmScreen
from station.tui.widgets.common import EventLines, ValueWidget
from tests.station.monitor.views import VIEWS
from tests.station.tui.monitor.session import LARGE, SMALL, MemorySession, Shown, shown

LOOKS = [  # the usual ones are the pictures of docs/how-to/monitor.md, see test_page.py
    ("waiting", SMALL, ""), ("alarming", SMALL, ""), ("blind", SMALL, ""), ("resting", SMALL, "question_mark"),
    ("located", LARGE, ""), ("side_by_side", LARGE, ""),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "size", "keys"), LOOKS, ids=lambda part: part if isinstance(part, str) else f"{part[0]}x{part[1]}"
)
def test_it_looks_as_it_did(
    name: str, size: tuple[int, int], keys: str, snap_compare: Callable[..., bool]
) -> None:
    app = MonitorApp(MemorySession(VIEWS[name]), refresh_hz=0.001, is_quiet=True)
    assert snap_compare(app, terminal_size=size, press=keys.split())


@pytest.mark.parametrize("size", [SMALL, LARGE], ids=["80x24", "120x40"])
async def test_nothing_is_cut_off(size: tuple[int, int]) -> None:
    async with shown(VIEWS["waiting"], size) as seen:
        for name, view in VIEWS.items():
            if not view.is_over:
                await seen.show(view)
                await seen.pilot.pause()
                assert not cut_off(seen), name
                assert seen.app.screen.max_scroll_y == 0, name


def cut_off(seen: Shown) -> list[object]:
    """Return what does not fit; the calibration's note and the state's sentence may end in dots."""
    found: list[object] = []
    for widget in seen.app.screen.walk_children():
        if not widget.display or isinstance(widget, EventLines):
            continue
        if not seen.app.screen.region.contains_region(widget.region):
            found.append((widget, widget.region))
        if isinstance(widget, Footer) and widget.max_scroll_x:
            found.append(widget)
        if isinstance(widget, ValueWidget) and widget.content_size.width:
            lines = widget.render().plain.split("\n")
            may_be_long = type(widget).__name__ in {"StateLine", "CalibrationLine"}
            is_wide = any(len(line) > widget.content_size.width for line in lines) and not may_be_long
            if is_wide or len(lines) > widget.content_size.height:
                found.append((widget, widget.render().plain))
    return found


REPORTED = [
    ("moving", ("+12.345 deg", "-4.321 deg", "moving", "RECORDING", "50.0 Hz", "no errors", "20 days old")),
    ("resting", ("at rest HDG 238.7", "0.003 0.070 deg", "0.031 1.006 deg/h", "-22.647 mg")),
    ("zeroed", ("+0.345 deg  from zero +12.000", "-0.321 deg  from zero -4.000")),
    ("alarming", ("✗ ALARM", "roll 12.3, limit 10 deg")),
    ("silent", ("✗ NO DATA", "check cable and power", "age 3.1 s")),
    ("aided", ("aid gnss 12.3 m/s", "2 lost")),
    ("steep", ("undefined at ±90°",)),
    ("uncalibrated", ("NONE: nominal", "NOT RECORDED")),
    ("not_located", ("NOT LOCATED 98 fixes", "better gyros")),
    (
        "located",
        ("HEADING 329.20 deg u 0.11 deg", "u 0.21 m, up 0.34 m", "4051 fixes 3 outliers", "20 m"),
    ),
    ("seeing", ("118 features, stamps 43 ms late", "camera 10.0.0.7:8080 19.8 Hz")),
    (
        "blind",
        (
            "✗ CAMERA 10.0.0.7:8080: no bytes",
            "✗ camera 10.0.0.7:8080",
            "no image for 4 s",
            "4 are needed: move further",
        ),
    ),
    (
        "side_by_side",
        (
            "filter joint, paper",
            "roll +12.345 +12.145 -0.200 deg",
            "pitch -4.321 -3.101 +1.220 deg",
            "bias of paper at this bank, deg",
            "roll -0.138 \u00b1 0.338 pitch +1.226 \u00b1 0.194",
        ),
    ),
    ("failing", ("paper: pitch beyond 80 deg", "use joint or mixer")),
    ("by_mixers", ("by paper-filter", "bias of paper-whole: needs a velocity")),
    ("behind", ("3 outliers 12 s behind",)),
    ("waiting", ("waiting for the first samples", "no attitude yet")),
]


@pytest.mark.parametrize("kind", ["plain", "laws", "located"])
async def test_it_says_what_matters(kind: str) -> None:
    async with shown(VIEWS["waiting"]) as seen:
        for name, reported in REPORTED:
            if kind != ("located" if VIEWS[name].location else "laws" if VIEWS[name].filters else "plain"):
                continue  # a run has one kind of view
            await seen.show(VIEWS[name])
            await seen.pilot.pause()
            words = " ".join(seen.text().split())
            assert [text for text in reported if " ".join(text.split()) not in words] == [], name


async def test_keys_ask_the_engine_and_leaving_a_recording_asks_first() -> None:
    async with shown(VIEWS["moving"]) as seen:
        await seen.pilot.press("m", "r", "z", "n")
        assert seen.session.sent == ["mark", "record", "zero", "restart"]
        await seen.pilot.press("q")
        assert isinstance(seen.app.screen, ConfirmScreen)
        await seen.pilot.press("n", "ctrl+c", "y")
        assert seen.session.sent[4:] == ["leave"]


async def test_the_map_and_the_horizon_take_turns_where_a_location_is_asked_for() -> None:
    async with shown(VIEWS["aided"]) as seen:
        await seen.pilot.press("l")
        assert seen.app.monitor.horizon.display
        await seen.show(VIEWS["located"])
        assert (seen.app.monitor.map.display, seen.app.monitor.horizon.display) == (True, False)
        await seen.pilot.press("l")
        assert (seen.app.monitor.map.display, seen.app.monitor.horizon.display) == (False, True)
        await seen.show(VIEWS["not_located"])
        assert seen.app.monitor.horizon.display


async def test_without_a_recording_it_is_left_at_once_and_closes_when_it_is_over() -> None:
    async with shown(VIEWS["uncalibrated"]) as seen:
        await seen.pilot.press("q")
        assert seen.session.sent == ["leave"]
        await seen.show(VIEWS["ended"])
        assert not seen.app.is_running
