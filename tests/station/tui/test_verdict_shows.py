"""``d`` and ``o`` at the verdict show what they name."""

import pytest

from station.tui.screens.diagnosis import NONE, DiagnosisScreen
from station.tui.screens.verdict import VerdictScreen
from tests.station.tui import views
from tests.station.tui.session import screens

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


async def test_a_campaign_without_a_diagnosis_says_so() -> None:
    bare = views.PASSED.model_copy(
        update={"verdict": views.PASSED.verdict.model_copy(update={"diagnosis_text": ""})}
    )
    async with screens(bare) as seen:
        await seen.press("d")
        await seen.pilot.pause()
        assert any(NONE[:40] in line for line in seen.lines())


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
        await seen.press("o")
        await seen.pilot.pause()
        assert any("no browser can be opened from here" in line for line in seen.lines())
