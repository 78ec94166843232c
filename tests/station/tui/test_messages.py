"""At 80x24 nothing that is said loses a word: the program's longest messages on every screen that shows them."""

import errno
from collections.abc import Sequence

import pytest
from textual.widget import Widget

from drivers.errors import DriverError, LinkLost, LinkSilent, PortBusy, PortDenied, WrongFormat
from station.errors import DataRefused, cannot_write
from station.guide.stages.guide import trouble_of
from station.guide.view import CalibrationView, StageName
from station.stream.connected_unit import UnitChanged
from station.stream.stream_events import Event
from tests.station.tui import start_views, views
from tests.station.tui.session import SMALL, Screens, screens

PORT = "/dev/serial/by-id/usb-FTDI_USB-RS422_A1B2C3D4"
STREAM = [
    LinkSilent(PORT, 1.8, 921600),
    WrongFormat(PORT, "novatel_rawimusx", 16384, 921600, "stim300"),
    WrongFormat(PORT, "counts", 16384, 921600, None, "they look like bytes at another baud rate: try 460800"),
    LinkLost(PORT, "device reports readiness to read but returned no data, not back within 30 s"),
    UnitChanged(PORT, "SIM-FOG3-000123456", "SIM-FOG3-000123457"),
    PortBusy(PORT),
]
OTHERS = [
    PortDenied(PORT),
    DataRefused("set-up", None, "latitude_deg 931.17", "a latitude of the slab from -90 to 90 deg", "correct it"),
    cannot_write("/srv/calibrations/2026/campaigns/2026-11-21_1240_SIM-7/dwell_03.mcap",
                 OSError(errno.ENOSPC, "No space left on device"), 40_000_000),
    UnitChanged(PORT, "SIM-FOG3-000123456", "SIM-FOG3-000123457", is_entered=True),
]  # fmt: skip
EVENTS = [
    "X points down is correct, but the heading is wrong: turn 135 deg more, counter-clockwise from above",
    "turn X+ and turn X- came back 0.15 deg, limit 0.04: one more turn X+ shows which was wrong",
    "warm-up was skipped: biases may drift by 0.12 deg/h and 1.3 ug; this is recorded, and uncertainties increase",
    *map(str, STREAM),
]
TILTED = "tilt the cube on a corner, X and Y half up, Z half down, near 45 deg; prop it; then leave it for 3600 s"
CAMPAIGN: tuple[StageName, ...] = ("place", "settle", "dwell", "turn")


def words(text: str) -> str:
    return " ".join(text.replace("▌", " ").split())


def shown_in(seen: Screens, widget: Widget) -> str:
    """Return what stands in the terminal where a widget is, as one line."""
    region = widget.region
    rows: Sequence[str] = seen.lines()[region.y : region.bottom]
    return words(" ".join(row[region.x : region.right] for row in rows))


@pytest.mark.parametrize("error", STREAM, ids=lambda error: type(error).__name__)
async def test_what_is_wrong_with_the_stream_is_reported_whole_and_once(error: DriverError) -> None:
    async with screens(CalibrationView(stage="connecting")) as seen:
        link = views.LINK.model_copy(update={"is_live": False, "word": trouble_of(error)[0], "name": PORT})
        event = Event(number=99, sound="rejected", text=str(error))
        for stage in (*CAMPAIGN, "warm_up", "paused") if error is STREAM[1] else ("dwell", "warm_up"):
            base = next(v for v in views.VIEWS.values() if v.stage == stage and v.question is None)
            update = {"link": link, "line": trouble_of(error)[1], "hint": str(error)}
            update |= {"events": (*base.events, event), "gates": None, "pose": None}
            await seen.show(base.model_copy(update=update))
            await seen.pilot.pause()
            screen = seen.app.screen
            banner = shown_in(seen, screen.banner)
            assert words(str(error)) in banner, (stage, error)
            assert words(trouble_of(error)[1]) in banner
            assert trouble_of(error)[0] in shown_in(seen, screen.link)
            assert words(" ".join(seen.lines())).count(str(error)[-30:]) <= 1
            assert screen.query_one("KeyLine").region.bottom == SMALL[1]


async def test_the_newest_event_is_whole() -> None:
    async with screens(views.HOLDING) as seen:
        for text in EVENTS:
            event = Event(number=99, sound="rejected", text=text)
            await seen.show(views.HOLDING.model_copy(update={"events": (*views.EVENTS, event)}))
            await seen.pilot.pause()
            assert words(text) in shown_in(seen, seen.app.screen.events), text


async def test_hints_and_instructions_are_whole() -> None:
    async with screens(CalibrationView(stage="connecting")) as seen:
        for view in views.VIEWS.values():
            if view.stage not in CAMPAIGN or view.question:
                continue
            for line, hint in ((view.line, view.hint), (TILTED, EVENTS[0])):
                await seen.show(view.model_copy(update={"line": line, "hint": hint}))
                await seen.pilot.pause()
                banner = shown_in(seen, seen.app.screen.banner)
                assert words(line) in banner
                assert words(hint) in banner


async def test_the_end_and_the_set_up_say_errors_whole() -> None:
    async with screens(CalibrationView()) as seen:
        for error in (*STREAM, *OTHERS):
            await seen.show(views.BROKEN.model_copy(update={"error": str(error)}))
            await seen.pilot.pause()
            assert words(str(error)) in shown_in(seen, seen.app.screen.query_one("#ended"))
        for error in (*STREAM, *OTHERS):
            start = start_views.START.start.model_copy(update={"refused": str(error)})
            await seen.show(start_views.START.model_copy(update={"start": start}))
            await seen.pilot.pause()
            assert words(str(error)) in shown_in(seen, seen.app.screen.query_one("#message"))


async def test_a_question_is_whole_with_its_choices() -> None:
    question = views.ASKING.question.model_copy(
        update={"text": "turn X+ and turn X- came back 0.15 deg, limit 0.04 deg: take the wider closure of "
                        "0.106 deg, which the solution then holds, or turn once more?"}
    )  # fmt: skip
    async with screens(views.ASKING.model_copy(update={"question": question})) as seen:
        await seen.pilot.pause()
        box = shown_in(seen, seen.app.screen.query_one("Label"))
        assert words(question.text) in box
        listed = shown_in(seen, seen.app.screen.query_one("OptionList"))
        assert all(words(choice.title) in listed for choice in question.choices)


@pytest.mark.parametrize("size", [(79, 24), (20, 8)])
async def test_a_terminal_that_is_too_small_says_what_is_needed_and_what_it_has(size: tuple[int, int]) -> None:
    async with screens(CalibrationView(), size) as seen:
        for view in (views.HOLDING, views.TURNING, views.PASSED, start_views.START, views.BROKEN):
            await seen.show(view)
            await seen.pilot.pause()
            reported = words(" ".join(seen.lines()))
            assert f"needs 80x24; this terminal has {size[0]}x{size[1]}" in reported
            assert "CUBE NOW" not in reported
        await seen.pilot.resize_terminal(80, 24)
        await seen.pilot.pause()
        assert "needs 80x24" not in " ".join(seen.lines())


async def test_why_a_turn_was_rejected_stays_in_sight_below_what_comes_next() -> None:
    reasons = [
        "turn X-: it was 2.00 revolutions, by the turns before it, expected 3 revolutions; once more",
        "turn X-: closure error 3.1 deg (u = 0.4 deg): the marks say where it ends; once more",
        "the unit was switched off and on: its biases are solved separately from before; it must warm up again",
    ]
    later = [
        Event(number=51, sound="start", text="turn now: 3 times counter-clockwise"),
        Event(number=52, sound="still", text="touched before the rotation: keep your hands off"),
    ]
    async with screens(views.TURNING) as seen:
        for reason in reasons:
            assert len(reason) > SMALL[0]
            for after in (later[1:], later):
                events = (*views.EVENTS, Event(number=50, sound="rejected", text=reason), *after)
                await seen.show(views.TURNING.model_copy(update={"events": events}))
                await seen.pilot.pause()
                reported = shown_in(seen, seen.app.screen.events)
                assert words(reason) in reported
                assert reported.endswith(after[-1].text)
                assert "REST" in " ".join(seen.lines())
                assert seen.app.screen.query_one("KeyLine").region.bottom == SMALL[1]
