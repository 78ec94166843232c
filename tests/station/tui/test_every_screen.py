"""Every stage has a screen; every screen fits its terminal, explains itself, and can be left."""

from typing import get_args

import pytest
from textual.widgets import Footer

from station.guide.view import CalibrationView, StageName
from station.tui.screens import screen_for
from station.tui.screens.framed_screen import RUNNING, TooSmall
from station.tui.screens.modals import ConfirmScreen, HelpScreen
from station.tui.screens.verdict import NumberTable
from station.tui.widgets.common import EventLines, ValueWidget
from tests.station.tui import views
from tests.station.tui.session import LARGE, PHONE, SMALL, Screens, screens

MAY_BE_CUT = (NumberTable, EventLines)  # one scrolls, the other's texts are any length


def of_stage(stage: StageName) -> CalibrationView:
    return next(view for view in views.VIEWS.values() if view.stage == stage)


async def test_every_stage_has_its_screen_also_when_a_view_says_nothing_else() -> None:
    async with screens(CalibrationView()) as seen:
        for stage in get_args(StageName):
            for view in (CalibrationView(stage=stage), of_stage(stage)):
                await seen.show(view)
                assert type(seen.app.screen) is screen_for(stage), stage
        assert len(seen.app.screen_stack) == 2


async def test_nothing_is_cut_off_and_all_keys_are_reported_in_a_large_terminal() -> None:
    async with screens(CalibrationView(), LARGE) as seen:
        for name, view in views.VIEWS.items():
            await seen.show(view)
            await seen.pilot.pause()
            assert not cut_off(seen), name
            assert view.question is not None or keys_missing(seen) == [], name


async def test_nothing_is_cut_off_and_all_keys_that_work_are_reported() -> None:
    """In the terminal's last line, with and without its focus, and in the palette."""
    async with screens(CalibrationView(), SMALL) as seen:
        for name, view in views.VIEWS.items():
            seen.app.app_focus = False  # another window has it
            await seen.show(view)
            await seen.pilot.pause()
            if view.question is None:
                assert keys_missing(seen) == [], f"{name}, out of focus"
            seen.app.app_focus = True
            await seen.pilot.pause()
            assert not cut_off(seen), name
            if view.question is not None:
                continue
            assert keys_missing(seen) == [], name
            if view.stage != "start":
                assert not_in_palette(seen) == set(), name


def not_in_palette(seen: Screens) -> set[str]:
    """Return what the footer or every screen offers and the palette does not."""
    shown = {key.description for key in seen.app.screen.query("FooterKey")} - {"All"}
    assert shown
    offered = {command.title for command in seen.app.get_system_commands(seen.app.screen)}
    return (shown | {"Sound", "High contrast", "Theme"}) - offered


def cut_off(seen: Screens) -> list[object]:
    """Return what does not fit: widgets outside the terminal, keys outside the footer, lines that are too long."""
    found: list[object] = []
    for screen in seen.app.screen_stack:
        for widget in screen.walk_children():
            if not widget.display or not widget.is_on_screen or isinstance(widget, MAY_BE_CUT):
                continue
            if not seen.app.screen.region.contains_region(widget.region):
                found.append((widget, widget.region))
            if isinstance(widget, Footer) and widget.max_scroll_x:
                found.append(widget)
            if isinstance(widget, ValueWidget) and widget.content_size.width:
                rows = sum(
                    -(-len(line) // widget.content_size.width) or 1 for line in widget.render().plain.split("\n")
                )
                if rows > widget.content_size.height:
                    found.append((widget, widget.render().plain))
    return found


async def test_help_explains_each_stage_and_its_keys_and_closes() -> None:
    async with screens(CalibrationView()) as seen:
        for stage in get_args(StageName):
            await seen.show(of_stage(stage))
            await seen.press("f1" if stage == "start" else "question_mark")
            assert isinstance(seen.app.screen, HelpScreen), stage
            reported = seen.app.screen.query_one("Static").render().plain
            assert len(reported.split("\n")[0]) > 20
            assert "four slow: rejected" in reported
            assert not cut_off(seen), stage
            await seen.press("escape")
            assert type(seen.app.screen) is screen_for(stage)


async def test_cancel_works_in_every_stage_and_asks_first() -> None:
    async with screens(CalibrationView()) as seen:
        for number, stage in enumerate(RUNNING):
            await seen.show(of_stage(stage))
            key = "escape" if stage == "start" else "c"
            await seen.press(key)
            assert isinstance(seen.app.screen, ConfirmScreen), stage
            assert not cut_off(seen)
            assert "database" in seen.app.screen.query_one("Label").render().plain
            await seen.press("n")
            assert len(seen.sent) == number
            await seen.press(key, "y")
            assert [command.verb for command in seen.sent] == ["cancel"] * (number + 1)


async def test_leaving_asks_first_in_every_stage_with_something_to_go_on_with() -> None:
    async with screens(views.CONNECTING) as seen:
        for stage in RUNNING[1:]:
            await seen.show(of_stage(stage))
            await seen.press("q")
            assert isinstance(seen.app.screen, ConfirmScreen), stage
            await seen.press("n")
            assert seen.sent == []
        await seen.press("q", "right", "enter")
        assert [command.verb for command in seen.sent] == ["leave"]


@pytest.mark.parametrize("key", ["ctrl+q", "ctrl+c"])
async def test_the_usual_keys_of_a_terminal_ask_to_leave_too(key: str) -> None:
    async with screens(views.HOLDING) as seen:
        await seen.press(key, "y")
        assert [command.verb for command in seen.sent] == ["leave"]


@pytest.mark.parametrize("stage", ["start", "stored", "failed"])
async def test_where_nothing_is_at_stake_leaving_closes_the_screens(stage: StageName) -> None:
    async with screens(of_stage(stage)) as seen:
        await seen.press("ctrl+q")
        assert not seen.app.is_running
    assert seen.sent == []


@pytest.mark.parametrize("key", ["enter", "q"])
async def test_the_end_says_what_became_of_the_data_and_a_key_closes_it(key: str) -> None:
    async with screens(views.BROKEN) as seen:
        reported = seen.app.screen.query_one("#ended Static").render().plain
        assert "The disk is full" in reported
        assert "All accepted steps are safe" in reported
        await seen.press(key)
        assert not seen.app.is_running


VERDICTS = [
    (views.PASSED, " ✓ PASS   All values are within the limits of SIM-FOG3."),
    (views.FAILED, " ✗ FAIL   The gyroscope bias x is 0.134 deg/h, the limit is 0.1 deg/h."),
    (views.AMBIGUOUS, f" ! PASS   {views.DOUBT}; All values are within the limits of SIM-FOG3."),
    (views.NOT_MEASURED, " ? NO LIMITS   no limits are stored for SIM-FOG3."),  # the word is not said twice
]


async def test_the_verdict_is_a_word_a_symbol_and_one_sentence() -> None:
    async with screens(views.SOLVING) as seen:
        for view, reported in VERDICTS:
            await seen.show(view)
            assert seen.app.screen.sentence.render().plain == reported
            assert seen.app.screen.sentence.has_class(view.verdict.word)
            assert view.verdict.status in seen.app.screen.facts["status"].query_one(".text").render().plain
            numbers = seen.app.screen.table.render().plain
            assert all(text in numbers for row in view.verdict.rows for text in (row.sigma, row.unit, row.limit))


@pytest.mark.parametrize("display", ["", ":0"])
async def test_what_is_stored_shows_its_seal_and_opens_its_report(
    display: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    async with screens(views.STORED) as seen:
        assert "9f2c41d07be85a63" in seen.app.screen.facts["stored"].query_one(".text").render().plain
        await seen.press("o")
        await seen.pilot.pause()
        assert "report.html" in seen.app.export_screenshot()  # said in either case
    assert opened == ([f"file://{views.STORED.verdict.report}"] if display else [])


def keys_missing(seen: Screens) -> list[str]:
    """Return what works now and stands nowhere in the terminal's last line with a key that does it."""
    offered: dict[str, list[str]] = {}
    for active in seen.app.screen.active_bindings.values():
        if active.binding.show and active.enabled:
            key = f"{seen.app.get_key_display(active.binding)} {active.binding.description}"
            offered.setdefault(active.binding.action, []).append(key)
    assert offered
    return [keys[0] for keys in offered.values() if not any(key in seen.lines()[-1] for key in keys)]


@pytest.mark.parametrize("has_focus", [True, False], ids=["in focus", "out of focus"])
async def test_a_verdict_of_many_words_scrolls_and_keeps_its_keys(has_focus: bool) -> None:
    words = tuple(f"warning {n}: {'word ' * 30}" for n in range(8))
    verdict = views.PASSED.verdict.model_copy(update={"warnings": words})
    async with screens(views.SOLVING) as seen:
        seen.app.app_focus = has_focus
        await seen.show(views.PASSED.model_copy(update={"verdict": verdict}))
        await seen.pilot.pause()
        assert "s Store" in seen.lines()[-1]
        for _ in range(20):
            await seen.press("down")
        assert "gyroscope bias z" in "\n".join(seen.lines())
        assert "s Store" in seen.lines()[-1]


async def test_nothing_is_cut_off_on_a_telephone_held_upright() -> None:
    """46 columns of a letter 14 px high, as a browser 390 px wide shows them."""
    async with screens(CalibrationView(), PHONE) as seen:
        for name, view in views.VIEWS.items():
            await seen.show(view)
            await seen.pilot.pause()
            assert not any(each.display for screen in seen.app.screen_stack for each in screen.query(TooSmall)), (
                name
            )
            assert not cut_off(seen), name
