"""The application: draws the session's view and sends what the operator asks. It knows nothing by itself."""

from collections.abc import Iterable
from functools import partial

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.screen import Screen

from station.monitor.session import Session
from station.monitor.view import View
from station.tui.bells import Bells
from station.tui.monitor.screen import MonitorScreen
from station.tui.themes import HIGH_CONTRAST, OURS, STATION


class MonitorApp(App[None]):
    """The screen of one monitor; parameters as of `station.tui.app.StationApp`."""

    TITLE = "FOG station"
    BINDINGS = [
        Binding(
            "ctrl+p", "command_palette", "All", key_display="^p", priority=True, tooltip="every action by its name"
        )
    ]

    def __init__(self, session: Session, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__()
        self._session, self._refresh_hz, self.is_quiet = session, refresh_hz, is_quiet
        self._view: View | None = None
        self._heard = 0
        self.bells = Bells(lambda: self.bell(), self.set_timer)
        self.animation_level = "none"
        for theme in (STATION, HIGH_CONTRAST):
            self.register_theme(theme)
        self.theme = STATION.name
        self.monitor = MonitorScreen(session.send)

    def get_theme_variable_defaults(self) -> dict[str, str]:
        """Give every theme the colours that are ours."""
        return super().get_theme_variable_defaults() | OURS

    async def on_mount(self) -> None:
        """Begin to look at the session."""
        await self.push_screen(self.monitor)
        self.pull()
        self.set_interval(1 / self._refresh_hz, self.pull)

    def pull(self) -> None:
        """Show the session's view if it is another; close when it is over."""
        view = self._session.view
        if view is self._view:
            return
        self._ring(view)
        self._view = view
        self.monitor.show(view)
        if view.is_over:
            self.exit()

    def _ring(self, view: View) -> None:
        new = [event for event in view.events if event.number > self._heard]
        self._heard = max([self._heard, *(event.number for event in new)])
        if self._view is not None and not self.is_quiet:
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
        """Leave, asking first while something is being recorded."""
        if self.screen is self.monitor:
            self.monitor.action_leave()

    def action_help_quit(self) -> None:
        """Take ctrl+c for a wish to leave."""
        if self.screen is self.monitor:
            self.monitor.action_leave()
