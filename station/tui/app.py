"""The application: draws the session's view and sends what the operator asks. It knows nothing by itself."""

from collections.abc import Iterable
from functools import partial

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.screen import Screen

from station.guide.command import Command
from station.guide.session import Session
from station.guide.view import View
from station.tui.bells import Bells
from station.tui.screens import SCREEN_FOR
from station.tui.screens.modal import Modal
from station.tui.screens.question import LATER, QuestionScreen
from station.tui.screens.stage import StageScreen
from station.tui.themes import HIGH_CONTRAST, OURS, STATION


class StationApp(App[None]):
    """The screens of one session.

    Parameters
    ----------
    session : Session
        Where views come from and commands go to.
    refresh_hz : float
        How often the view is looked at.
    is_quiet : bool
        Whether the bell stays silent.
    """

    TITLE = "FOG station"
    BINDINGS = [
        Binding(
            "ctrl+p", "command_palette", "All", key_display="^p", priority=True, tooltip="every action by its name"
        )
    ]

    def __init__(self, session: Session, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__()
        self._session, self._refresh_hz = session, refresh_hz
        self._view: View | None = None
        self._base: StageScreen | None = None
        self._heard = -1  # the newest event that was heard
        self._postponed: object = None  # the question that was put off
        self.is_quiet = is_quiet
        self.bells = Bells(lambda: self.bell(), self.set_timer)
        self.animation_level = "none"
        for theme in (STATION, HIGH_CONTRAST):
            self.register_theme(theme)
        self.theme = STATION.name

    def get_theme_variable_defaults(self) -> dict[str, str]:
        """Give every theme the colours that are ours."""
        return super().get_theme_variable_defaults() | OURS

    def on_mount(self) -> None:
        """Begin to look at the session."""
        self.pull()
        self.set_interval(1 / self._refresh_hz, self.pull)

    def pull(self) -> None:
        """Show the session's view if it is another."""
        view = self._session.view
        if view is not self._view:
            self._ring(view, is_first=self._view is None)
            self._view = view
        self._close_what_does_not_fit(view)
        self._show(view)
        self._ask(view)

    def _close_what_does_not_fit(self, view: View) -> None:
        is_other = not isinstance(self._base, SCREEN_FOR[view.stage])
        while len(self.screen_stack) > 2:
            top = self.screen
            if top.fits(view) if isinstance(top, Modal) else not is_other:
                return
            self.pop_screen()

    def _show(self, view: View) -> None:
        """Show the view on its screen; a modal that fits keeps the screen under it until it is answered."""
        wanted = SCREEN_FOR[view.stage]
        if self._base is None or self._base not in self.screen_stack:
            self._base = wanted(self._session.send)
            self.push_screen(self._base)
        elif not isinstance(self._base, wanted) and self.screen is self._base:
            self._base = wanted(self._session.send)
            self.switch_screen(self._base)
        if self._base.view is not view:
            self._base.show(view)

    def _ask(self, view: View) -> None:
        question = view.question
        if question is None:
            self._postponed = None
        elif question != self._postponed and self.screen is self._base:
            self._postponed = question
            self.push_screen(QuestionScreen(question), self._answer)

    def action_ask(self) -> None:
        """Ask the question that was put off."""
        self._postponed = None

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer to answer while there is a question."""
        return self._session.view.question is not None if action == "ask" else True

    def _answer(self, key: str | None) -> None:
        if key not in (None, LATER):
            self._session.send(Command(verb="answer", key=key))

    def _ring(self, view: View, *, is_first: bool) -> None:
        new = [event for event in view.events if event.number > self._heard]
        self._heard = max([self._heard, *(event.number for event in new)])
        if not is_first and not self.is_quiet:
            for event in new:
                self.bells.ring(event.sound)

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer every action of the screen in the palette, then those of the application."""
        for active in screen.active_bindings.values():
            if active.node is screen and active.binding.show and active.enabled:
                action = partial(screen.run_action, active.binding.action)
                yield SystemCommand(active.binding.description, active.tooltip or active.binding.tooltip, action)
        yield SystemCommand("Sound", "turn the bell off, or on again", self.action_sound)
        yield SystemCommand("High contrast", "the theme of high contrast, or back", self.action_contrast)
        yield from super().get_system_commands(screen)

    def action_sound(self) -> None:
        """Turn the bell off or on."""
        self.is_quiet = not self.is_quiet
        self.notify("sounds are off" if self.is_quiet else "sounds are on")

    def action_contrast(self) -> None:
        """Take the theme of high contrast, or go back."""
        self.theme = STATION.name if self.theme == HIGH_CONTRAST.name else HIGH_CONTRAST.name

    async def action_quit(self) -> None:
        """Ask before leaving a campaign."""
        if self._base is not None and self.screen is self._base:
            self._base.action_leave()

    def action_help_quit(self) -> None:
        """Take ctrl+c for a wish to leave."""
        if self._base is not None and self.screen is self._base:
            self._base.action_leave()
