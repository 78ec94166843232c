"""``d`` and ``o`` at the verdict show what they name."""

import pytest

from station.guide.view import VerdictRow
from station.tui.screens.modals import DiagnosisScreen
from station.tui.screens.verdict import VerdictScreen
from tests.station.tui import views
from tests.station.tui.session import LARGE, SMALL, screens

LINES = [f"line {number:>3} {'.' * 71}" for number in range(1, 101)]  # as wide as a diagnosis may be
DIAGNOSED = views.PASSED.model_copy(
    update={"verdict": views.PASSED.verdict.model_copy(update={"diagnosis_text": "\n".join(LINES)})}
)


async def test_d_shows_all_of_the_diagnosis_line_by_line_and_any_way_back_leads_to_the_verdict() -> None:
    async with screens(DIAGNOSED) as seen:
        for back in ("escape", "d", "q", "enter"):
            await seen.press("d")
            assert isinstance(seen.app.screen, DiagnosisScreen)
            await seen.press(back)
            assert isinstance(seen.app.screen, VerdictScreen)
        await seen.press("d")
        await seen.pilot.pause()
        shown = seen.lines()
        assert shown[1].startswith("line   1")
        assert "esc" in shown[-1].lower()
        await seen.press(*["pagedown"] * 12)
        await seen.pilot.pause()
        assert any("line 100" in line for line in seen.lines())
        assert seen.sent == []


async def test_a_browser_opens_the_report_at_its_own_server(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    async with screens(DIAGNOSED) as seen:
        monkeypatch.setattr(type(seen.app), "is_web", property(lambda _: True))
        monkeypatch.setattr(seen.app, "open_url", asked.append)
        monkeypatch.setattr("webbrowser.open", pytest.fail)
        await seen.press("o")
    assert asked == ["report"]


async def test_where_no_browser_can_be_opened_the_file_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    async with screens(DIAGNOSED) as seen:
        await seen.press("pagedown", "o")
        await seen.pilot.pause()
        assert any("no browser can be opened from here" in line for line in seen.lines())
        assert not seen.app._notifications  # noqa: SLF001  nothing lies over what is to be read
        assert any(views.PASSED.verdict.worst_residual in line for line in seen.lines())


WIDE = VerdictRow(
    name="accelerometer bias two direction y", value="-123456.789", sigma="0.080", expanded="0.16", unit="ug",
    limit="-12000 to 12500.5 ug less 1.64 sigma", verdict="NOT_MEASURED", change="+0.453 ug (4.0 sigma)",
)  # fmt: skip
SCALE = VerdictRow(
    name="accelerometer scale factor x", value="36000.0132", sigma="0.0021", expanded="0.0042", unit="count/(g s)",
    limit="33000 to 39000 count/(g s) less 2 sigma", verdict="PASS",
)  # fmt: skip


@pytest.mark.parametrize("size", [SMALL, LARGE])
async def test_no_number_and_no_limit_is_cut_however_narrow_the_screen(size: tuple[int, int]) -> None:
    rows = (*views.ROWS, SCALE, WIDE)
    view = views.PASSED.model_copy(update={"verdict": views.PASSED.verdict.model_copy(update={"rows": rows})})
    async with screens(view, size) as seen:
        seen_lines: set[str] = set()
        for _ in range(12):
            seen_lines |= {line.strip(" ▁▂▃▄▅▆▇█▉▊▋▌▍▎▏") for line in seen.lines()}
            await seen.press("pagedown")
            await seen.pilot.pause()
        cells = [line.split("  ") for line in seen_lines]
        written = {cell.strip().removeprefix("limit ").removeprefix("change ") for line in cells for cell in line}
        for row in rows:
            assert {row.name, row.value, row.expanded, row.unit, row.limit, row.change} - {""} <= written


async def test_an_ambiguous_pass_has_the_colour_of_a_warning_and_storing_it_says_why_again() -> None:
    async with screens(views.PASSED) as seen:
        assert not seen.app.screen.sentence.has_class("ambiguous")
        await seen.show(views.AMBIGUOUS)
        assert seen.app.screen.sentence.has_class("ambiguous")
        await seen.press("s")
        await seen.pilot.pause()
        asked = " ".join(str(label.render()) for label in seen.app.screen.query("Label"))
        assert views.DOUBT in asked
        await seen.press("n", "r")
    assert [(command.verb, command.step) for command in seen.sent] == [("redo", "dwell_04")]
