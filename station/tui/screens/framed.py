"""The frame of the screens that follow a live IMU: banner above, events and link below."""

from collections.abc import Callable
from dataclasses import replace

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content

from station.guide.command import OperatorCommand
from station.guide.view import CalibrationView, LinkView
from station.text import plural
from station.tui.screens.stage import StageScreen
from station.tui.widgets.banner import Banner, BannerText
from station.tui.widgets.event_lines import EventLines
from station.tui.widgets.redrawn_on_change import ValueWidget

NO_DATA = "NO DATA"


class LinkLine(ValueWidget[LinkView]):
    """Rate, bad frames, lost samples, gaps, temperature."""

    DEFAULT_CSS = """
    LinkLine { text-wrap: wrap; height: auto; padding: 0 1; background: $panel; }
    LinkLine.silent { background: $error; color: $background; text-style: bold; }
    """

    def _drawn(self, link: LinkView) -> Content:
        if not link.is_live:
            return Content(f"✗ {link.word or NO_DATA}  {link.name}")  # the banner says the rest
        if not link.rate_hz:
            said = f"… {link.name}  nothing received yet" if link.name else "… no IMU connected yet"
            return Content.styled(said, "$muted")
        numbers = f"{link.rate_hz:.1f} Hz  {link.bad_frames} bad  {link.lost} lost  {plural(link.gaps, 'gap')}"
        warm = "" if link.temperature_c is None else f"  {link.temperature_c:.1f} °C"
        trouble = (f"  {link.text}", "bold $warning")
        return Content.assemble(("✓ live ", "bold $success"), f" {link.name}  {numbers}{warm}", trouble)


class FramedScreen(StageScreen):
    """A subclass says what is `_now` and composes the `_inner` part."""

    DEFAULT_CSS = """
    FramedScreen EventLines { height: auto; max-height: 4; }
    FramedScreen.-tall Banner { padding: 1 0; }
    FramedScreen.-tall EventLines { height: 5; }
    FramedScreen #inner { height: 1fr; }
    """

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__(send)
        self.banner, self.events, self.link = Banner(), EventLines(keeps_reason=True), LinkLine()

    def _body(self) -> ComposeResult:
        yield self.banner
        with Vertical(id="inner"):
            yield from self._inner()
        yield self.events
        yield self.link

    def _inner(self) -> ComposeResult:
        """Lay out what is inside the frame."""
        raise NotImplementedError

    def _now(self, view: CalibrationView) -> BannerText:
        """Return what the banner says."""
        raise NotImplementedError

    def _draw(self, view: CalibrationView) -> None:
        now = self._now(view)
        if not view.link.is_live and view.stage != "connecting":
            now = replace(now, word=view.link.word or NO_DATA, symbol="✗", colour="$error")
        self.banner.show(now)
        self.events.show(tuple(event for event in view.events if event.text != now.hint))  # not said twice
        self.link.show(view.link)
        self.link.set_class(not view.link.is_live, "silent")
