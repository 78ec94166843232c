"""The frame of the screens that follow a live IMU: banner above, events and link below."""

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from station.guide.command import OperatorCommand
from station.guide.view import CalibrationView
from station.tui.screens.stage import StageScreen
from station.tui.widgets.banner import Banner, BannerText
from station.tui.widgets.event_lines import EventLines
from station.tui.widgets.link_line import NO_DATA, LinkLine


class FramedScreen(StageScreen):
    """A subclass says what is `now`, and has a ``TEXT`` or composes its own `inner` part."""

    TEXT: ClassVar[str] = ""

    DEFAULT_CSS = """
    FramedScreen #text { height: auto; padding: 1 2; }
    FramedScreen #events { height: auto; max-height: 4; }
    FramedScreen.-tall #banner { padding: 1 0; }
    FramedScreen.-tall #events { height: 5; }
    FramedScreen #inner { height: 1fr; }
    """

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__(send)
        self.banner, self.events, self.link = Banner(), EventLines(keeps_reason=True), LinkLine()

    def body(self) -> ComposeResult:
        """Lay out the frame."""
        yield self.banner
        with Vertical(id="inner"):
            yield from self.inner()
        yield self.events
        yield self.link

    def inner(self) -> ComposeResult:
        """Lay out what is inside the frame."""
        yield Static(self.TEXT, id="text", markup=False)

    def now(self, view: CalibrationView) -> BannerText:
        """Return what the banner says."""
        raise NotImplementedError

    def draw(self, view: CalibrationView) -> None:
        """Show a view in the frame."""
        now = self.now(view)
        if not view.link.is_live and view.stage != "connecting":
            now = replace(now, word=view.link.word or NO_DATA, symbol="✗", colour="$error")
        self.banner.show(now)
        self.events.show(tuple(event for event in view.events if event.text != now.hint))  # not said twice
        self.link.show(view.link)
