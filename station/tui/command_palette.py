"""Textual's palette of commands, whose waits end with it."""

from typing import Any

from textual.command import CommandList, CommandPalette
from textual.timer import Timer, TimerCallback


class Palette(CommandPalette):
    """It waits before it says that nothing was found; closed meanwhile, it would look for a list that has gone."""

    def set_timer(self, delay: float, callback: TimerCallback | None = None, **options: Any) -> Timer:
        """Call back after ``delay`` [s] if the palette's list is still there; ``options`` are Textual's."""

        def while_there() -> Any:
            return callback() if callback is not None and self.query(CommandList) else None

        return super().set_timer(delay, while_there, **options)
