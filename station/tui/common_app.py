"""What the applications have in common: themes, bells, the palette of all actions."""

from collections.abc import Iterable, Sequence
from functools import partial

from textual.app import App, SystemCommand
from textual.binding import Binding
from textual.screen import Screen

from station.stream.stream_events import Event, NewEvents
from station.tui.bells import Bells
from station.tui.command_palette import Palette
from station.tui.themes import HIGH_CONTRAST, OURS, STATION


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
        """Take ctrl+q for a wish to leave."""
        self.action_help_quit()

    def action_help_quit(self) -> None:
        """Take ctrl+c for a wish to leave: as the screen in front does, what lies over it is answered first."""
        if leave := getattr(self.screen, "action_leave", None):
            leave()

    def action_command_palette(self) -> None:
        """Open the palette of all actions."""
        if not isinstance(self.screen, Palette):
            self.push_screen(Palette(id="--command-palette"))

    def get_theme_variable_defaults(self) -> dict[str, str]:
        """Give every theme the colours that are ours."""
        return super().get_theme_variable_defaults() | OURS

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
        """Turn the bell off or on."""
        self.is_quiet = not self.is_quiet
        self.notify("sounds are off" if self.is_quiet else "sounds are on")

    def action_contrast(self) -> None:
        """Take the theme of high contrast, or go back."""
        self.theme = STATION.name if self.theme == HIGH_CONTRAST.name else HIGH_CONTRAST.name
