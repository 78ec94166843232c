"""The application: draws the session's view and sends what the operator asks. It knows nothing by itself.

`CommonApp` is what it shares with the monitor: themes, bells, the palette of all actions.
"""

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.command import CommandList, CommandPalette
from textual.screen import Screen
from textual.theme import Theme
from textual.timer import Timer, TimerCallback

from station.guide.view import CalibrationSession, CalibrationView, OperatorCommand
from station.stream.stream_events import Event, NewEvents, Sound
from station.tui.screens import screen_for
from station.tui.screens.framed_screen import StageScreen
from station.tui.screens.modals import ANSWER_LATER, Modal, QuestionScreen

EXTRA_COLOURS = {  # colours that no theme of Textual's has; the axes are red, green and blue
    "axis-x": "#ff6b6b", "axis-y": "#5fd38d", "axis-z": "#5aa9ff",
    "muted": "#8a99a8", "sky": "#1f5a8c", "ground": "#5c4326",
}  # fmt: skip
STATION = Theme(
    "station", primary="#4aa3df", secondary="#2f6f9f", accent="#ffb454", warning="#ffb454", error="#ff6b6b",
    success="#5fd38d", foreground="#dde5ec", background="#10161d", surface="#18212b", panel="#202c38",
    variables=EXTRA_COLOURS,
)  # fmt: skip
HIGH_CONTRAST = Theme(
    "high-contrast", primary="#00d7ff", secondary="#00afd7", accent="#ffff00", warning="#ffff00", error="#ff5f5f",
    success="#00ff5f", foreground="#ffffff", background="#000000", surface="#000000", panel="#1c1c1c",
    text_alpha=1.0,
    variables={
        "axis-x": "#ff5f5f", "axis-y": "#00ff5f", "axis-z": "#5fafff",
        "muted": "#ffffff", "sky": "#0000af", "ground": "#5f3700",
    },
)  # fmt: skip


class Palette(CommandPalette):
    """It waits before it says that nothing was found; closed meanwhile, it would look for a list that has gone."""

    def set_timer(self, delay: float, callback: TimerCallback | None = None, **options: Any) -> Timer:
        """Call back after ``delay`` [s] if the palette's list is still there; ``options`` are Textual's."""

        def while_there() -> Any:
            return callback() if callback is not None and self.query(CommandList) else None

        return super().set_timer(delay, while_there, **options)


# When each stroke follows the one before [s]. Terminals merge strokes closer than about 0.1 s.
BELL_PATTERNS: dict[Sound, tuple[float, ...]] = {
    "": (),
    "start": (0.0,),
    "still": (0.0, 0.5),
    "accepted": (0.0, 0.18, 0.18),
    "rejected": (0.0, 0.8, 0.8, 0.8),
}
PATTERN_GAP_S = 0.7  # between two patterns
MAX_STROKES = 12  # strokes: what has become older than that is not news


class Bells:
    """Rings patterns one after the other: ``stroke`` the bell once, ``later`` calls after so many seconds."""

    def __init__(self, stroke: Callable[[], None], later: Callable[[float, Callable[[], None]], object]) -> None:
        self._stroke, self._later = stroke, later
        self._waits: deque[float] = deque()
        self._is_ringing = False

    def ring(self, sound: Sound) -> None:
        """Ring a pattern, after those that ring already."""
        waits = BELL_PATTERNS[sound]
        if len(self._waits) + len(waits) > MAX_STROKES or not waits:
            return
        self._waits += (waits[0] + PATTERN_GAP_S, *waits[1:]) if self._is_ringing else waits
        if not self._is_ringing:
            self._next()

    def _next(self) -> None:
        self._is_ringing = bool(self._waits)
        if not self._is_ringing:
            return
        if wait := self._waits.popleft():
            self._later(wait, self._strike)
        else:  # at once: a timer of no time never fires
            self._strike()

    def _strike(self) -> None:
        self._stroke()
        self._next()


class CommonApp(App[None]):
    """An application in our colours; ``is_quiet`` keeps the bell silent, ``refresh_hz`` is how often it pulls."""

    TITLE = "FOG station"
    BINDINGS = [
        Binding("ctrl+p", "command_palette", "All", key_display="^p", priority=True, tooltip="all actions by name")
    ]

    def __init__(self, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__()
        self._refresh_hz, self.is_quiet = refresh_hz, is_quiet
        self._new_events = NewEvents()
        self.bells = Bells(lambda: self.bell(), self.set_timer)
        self.animation_level = "none"
        for theme in (STATION, HIGH_CONTRAST):
            self.register_theme(theme)
        self.theme = STATION.name

    async def on_mount(self) -> None:
        """Begin to look at the session."""
        self.pull()
        self.set_interval(1 / self._refresh_hz, self.pull)

    def pull(self) -> None:
        """Show the session's view if it is another."""
        raise NotImplementedError

    async def action_quit(self) -> None:
        self.action_help_quit()

    def action_help_quit(self) -> None:
        """Take ctrl+c for a wish to leave: as the screen in front does, what lies over it is answered first."""
        if leave := getattr(self.screen, "action_leave", None):
            leave()

    def action_command_palette(self) -> None:
        if not isinstance(self.screen, Palette):
            self.push_screen(Palette(id="--command-palette"))

    def get_theme_variable_defaults(self) -> dict[str, str]:
        """Give every theme the colours that are ours."""
        return super().get_theme_variable_defaults() | EXTRA_COLOURS

    def ring(self, events: Sequence[Event], *, is_first: bool) -> None:
        """Ring for the events that are new; those of the first view are old."""
        new = self._new_events.of(events)
        if not is_first and not self.is_quiet:
            for event in new:
                self.bells.ring(event.sound)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer every action of the screen in the palette, then those of the application."""
        for active in screen.active_bindings.values():
            if active.node is screen and active.binding.show and active.enabled:
                action = partial(screen.run_action, active.binding.action)
                yield SystemCommand(active.binding.description, active.tooltip or active.binding.tooltip, action)
        yield SystemCommand("Sound", "sounds on or off", self.action_sound)
        yield SystemCommand("High contrast", "high contrast on or off", self.action_contrast)
        yield from super().get_system_commands(screen)

    def action_sound(self) -> None:
        self.is_quiet = not self.is_quiet
        self.notify("sounds are off" if self.is_quiet else "sounds are on")

    def action_contrast(self) -> None:
        self.theme = STATION.name if self.theme == HIGH_CONTRAST.name else HIGH_CONTRAST.name


class StationApp(CommonApp):
    """The screens of one session, from which views come and to which commands go."""

    def __init__(self, session: CalibrationSession, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__(refresh_hz=refresh_hz, is_quiet=is_quiet)
        self._session = session
        self._view: CalibrationView | None = None
        self._base: StageScreen | None = None
        self._postponed: object = None  # the question that was put off

    def pull(self) -> None:
        """Show the session's view if it is another."""
        view = self._session.view
        if view is not self._view:
            self.ring(view.events, is_first=self._view is None)
            self._view = view
        self._close_outdated_modals(view)
        self._show(view)
        self._ask(view)

    def _close_outdated_modals(self, view: CalibrationView) -> None:
        is_other = not isinstance(self._base, screen_for(view.stage))
        while len(self.screen_stack) > 2:
            top = self.screen
            if top.fits(view) if isinstance(top, Modal) else not is_other:
                return
            self.pop_screen()

    def _show(self, view: CalibrationView) -> None:
        """Show the view on its screen; a modal that fits keeps the screen under it until it is answered."""
        wanted = screen_for(view.stage)
        if self._base is None or self._base not in self.screen_stack:
            self._base = wanted(self._session.send)
            self.push_screen(self._base)
        elif not isinstance(self._base, wanted) and self.screen is self._base:
            self._base = wanted(self._session.send)
            self.switch_screen(self._base)
        if self._base.view is not view:
            self._base.show(view)

    def _ask(self, view: CalibrationView) -> None:
        question = view.question
        if question is None:
            self._postponed = None
        elif question != self._postponed and self.screen is self._base:
            self._postponed = question
            self.push_screen(QuestionScreen(question), self._answer)

    def action_ask(self) -> None:
        self._postponed = None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        return self._session.view.question is not None if action == "ask" else True

    def _answer(self, key: str | None) -> None:
        if key not in (None, ANSWER_LATER):
            self._session.send(OperatorCommand(verb="answer", key=key))
