"""The base of all screens, the frame of those that follow a live IMU, and the screen that waits."""

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar, get_args

from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding
from textual.containers import Vertical
from textual.content import Content
from textual.screen import Screen
from textual.widgets import Static

from station.guide.view import ENDED_STAGES, CalibrationView, CommandVerb, LinkView, OperatorCommand, StageName
from station.text import plural
from station.tui.screens.modals import MIN_COLUMNS, ConfirmScreen, HelpScreen, keys_of
from station.tui.widgets.common import (
    Banner,
    BannerText,
    EventLines,
    KeyLine,
    TitleBar,
    ValueWidget,
    duration_in_words,
)

RUNNING: tuple[StageName, ...] = tuple(
    stage for stage in get_args(StageName) if stage not in {*ENDED_STAGES, "stored"}
)
CANCEL_TEXT = (
    "All recordings stay as files in the folder. The database is unchanged: no calibration is stored, "
    "and this campaign cannot be resumed."
)
LEAVE_CAMPAIGN_TEXT = (
    "All accepted steps are safe. The step in progress is not kept. The start screen offers to resume it."
)
COMMON_KEYS = ("app.ask", "leave", "cancel", "help", "command_palette")  # the keys of every screen
MIN_SIZE = (MIN_COLUMNS, 24)  # columns, rows
PHONE_SIZE = (44, 34)  # columns, rows of a telephone held upright: parts stand below instead of next to each other
CAMPAIGN_GOES_ON = "The campaign continues, and the keys work"


def progress(view: CalibrationView) -> str:
    """Return how far the campaign is: ``step 8 of 18, 21 min left``."""
    total = len(view.steps)
    if not total:
        return ""
    if view.stage in ENDED_STAGES:
        return f"{view.done} of {total} steps done"
    step = f"step {view.done + 1} of {total}" if view.done < total else f"{total} of {total} steps done"
    return f"{step}, {duration_in_words(view.remaining_s)} left" if view.remaining_s > 0 else step


class TooSmall(ValueWidget[bool]):
    """Says what is needed and what there is; the screen comes back by itself once there is room.

    ``value``: whether a campaign goes on meanwhile.
    """

    DEFAULT_CSS = """
    TooSmall {
        layer: above; display: none; width: 100%; height: 100%; padding: 1 2; text-wrap: wrap;
        background: $background;
    }
    """

    def _drawn(self, goes_on: bool) -> Content:
        """Draw the sentence."""
        columns, rows = self.app.size
        return Content.assemble(
            (f"needs {MIN_SIZE[0]}x{MIN_SIZE[1]}", "bold $warning"),
            f"; this terminal has {columns}x{rows}: make it larger, or its font smaller. "
            f"{CAMPAIGN_GOES_ON if goes_on else 'Keys work'}. --plain works in any terminal.",
        )


class StageScreen(Screen[None]):
    """A screen of one or more stages: made with a way to send commands, then shown views.

    A subclass composes itself and draws in `_draw`, which is called for every new view once all is mounted.
    ``HELPS`` explains its stages.
    """

    BINDINGS = [
        Binding("a", "app.ask", "Answer", tooltip="answer the postponed question"),
        Binding("q", "leave", "Leave", tooltip="stop here and resume later"),
        Binding("c", "cancel", "Cancel", tooltip="cancel the campaign; the database stays unchanged"),
        Binding("question_mark", "help", "Help", key_display="?", tooltip="help for this screen, and all keys"),
    ]
    DEFAULT_CSS = """
    StageScreen { layers: default above; }
    StageScreen.-cramped > TooSmall, StageScreen.-low > TooSmall { display: block; }
    StageScreen.-phone.-short > TooSmall { display: block; }
    StageScreen.-phone Banner { max-height: 8; padding: 0; }
    StageScreen.-phone KeyLine { layout: grid; grid-size: 4; height: auto; }
    """
    HORIZONTAL_BREAKPOINTS = [
        (0, "-cramped"), (PHONE_SIZE[0], "-phone"), (MIN_SIZE[0], "-narrow"), (112, "-wide"),
    ]  # fmt: skip
    VERTICAL_BREAKPOINTS = [(0, "-low"), (MIN_SIZE[1], "-short"), (34, "-tall")]
    HELPS: ClassVar[dict[StageName, str]] = {}

    def __init__(self, send: Callable[[OperatorCommand], None]) -> None:
        super().__init__()
        self._send = send
        self._is_ready = False
        self._keys: object = None
        self.view = CalibrationView()
        self.title_bar, self.too_small = TitleBar(), TooSmall()

    def compose(self) -> ComposeResult:
        self._fit()
        yield self.title_bar
        yield from self._body()
        yield KeyLine()
        yield self.too_small

    def _fit(self) -> None:
        """Take the classes of the terminal's size now: else the next resize event computes all styles again."""
        points = zip(self.app.size, (self.HORIZONTAL_BREAKPOINTS, self.VERTICAL_BREAKPOINTS), strict=True)
        for size, names in points:
            self.add_class([name for least, name in names if size >= least][-1], update=False)

    def _body(self) -> ComposeResult:
        """Lay out what is between title and keys."""
        raise NotImplementedError

    def _draw(self, view: CalibrationView) -> None:
        """Show a view in the body."""
        raise NotImplementedError

    def _keys_depend_on(self, view: CalibrationView) -> object:
        """Return what decides which keys are offered."""
        return view.stage

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys that work now, a screen's own before those of every screen."""
        return dict(
            sorted(super().active_bindings.items(), key=lambda item: item[1].binding.action in COMMON_KEYS)
        )

    def on_mount(self) -> None:
        """Draw what was shown before there was anything to draw on."""
        self._is_ready = True
        self.show(self.view)

    def show(self, view: CalibrationView) -> None:
        """Take a new view."""
        self.view = view
        if not self._is_ready:
            return
        campaign = view.folder.rstrip("/").rpartition("/")[2]
        title = f"{view.unit or 'FOG station'}  {campaign or 'guided calibration'}"
        self.title_bar.show((title, progress(view)))
        self.too_small.show(bool(view.steps) and view.verdict is None and view.stage in RUNNING)
        self._draw(view)
        if (keys := (view.question is None, self._keys_depend_on(view))) != self._keys:
            self._keys = keys
            self.refresh_bindings()

    def action_order(self, verb: CommandVerb, step: str = "", folder: str = "", url: str = "") -> None:
        self._send(OperatorCommand(verb=verb, step=step, folder=folder, url=url))

    def confirm(self, title: str, text: str, yes: str, verb: CommandVerb, *stages: StageName) -> None:
        """Send a command once the operator has agreed."""

        def answered(answer: bool | None) -> None:
            if answer:
                self.action_order(verb)

        self.app.push_screen(ConfirmScreen(title, text, yes, stages or RUNNING), answered)

    def action_leave(self) -> None:
        self.confirm("Leave and resume later?", LEAVE_CAMPAIGN_TEXT, "Yes, leave", "leave")

    def action_cancel(self) -> None:
        self.confirm("Cancel the campaign?", CANCEL_TEXT, "Yes, cancel", "cancel")

    def action_help(self) -> None:
        text = self.HELPS.get(self.view.stage, self.view.line)
        self.app.push_screen(HelpScreen(self.view.stage, text, keys_of(self)))


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
            text = f"… {link.name}  nothing received yet" if link.name else "… no IMU connected yet"
            return Content.styled(text, "$muted")
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
        self.events.show(tuple(event for event in view.events if event.text != now.hint))  # not shown twice
        self.link.show(view.link)
        self.link.set_class(not view.link.is_live, "silent")


class WaitingScreen(FramedScreen):
    """Says what is waited for."""

    HELPS = {
        "connecting": "The station opens the port, finds the frames and identifies the unit.\n\n"
        "If no data arrive: is the IMU powered? Are port and baud rate correct?\n"
        "Are A and B of the RS-422 pair swapped? c cancels.",
        "solving": "The joint solve runs over all accepted steps. The IMU is no longer needed; all is on the "
        "disk.",
    }
    DEFAULT_CSS = "WaitingScreen #text { height: auto; padding: 1 2; }"

    def _inner(self) -> ComposeResult:
        self.text = Static(id="text", markup=False)
        yield self.text

    def _now(self, view: CalibrationView) -> BannerText:
        symbol = "∑" if view.stage == "solving" else "…"
        return BannerText(view.stage.upper(), symbol, "$primary", view.line, view.hint)

    def _draw(self, view: CalibrationView) -> None:
        if view.stage in self.HELPS:  # else the wait is over, and a modal that is open keeps this under it
            super()._draw(view)
            self.text.update(self.HELPS[view.stage])
