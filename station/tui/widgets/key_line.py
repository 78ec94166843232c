"""The keys that work now, in the last line of every screen."""

from textual.app import ComposeResult
from textual.screen import Screen
from textual.widgets import Footer

PHONE_COLUMNS = 4  # keys in a line of 44 columns


class KeyLine(Footer):
    """A footer that is drawn whether the terminal has the focus or not.

    Textual's own is not composed while another window has the focus, which is so whenever a screen changes under
    a technician who looks at the cube, or whose browser shows another tab.
    """

    DEFAULT_CSS = "KeyLine { padding-left: 1; }"

    def __init__(self) -> None:
        super().__init__(compact=True, show_command_palette=False)
        self._drawn: object = None  # the keys that stand there

    def compose(self) -> ComposeResult:
        """Lay out the keys: in one line, on a telephone in several."""
        yield from super().compose()
        if self.screen.has_class("-phone"):
            self.styles.grid_size_columns = PHONE_COLUMNS

    def bindings_changed(self, screen: Screen[object]) -> None:
        """Draw the keys anew if they are others."""
        self._bindings_ready = True
        if self.is_attached and screen is self.screen:
            self.call_after_refresh(self._draw_others)

    async def _draw_others(self) -> None:
        """Draw the keys; a screen tells of a change a dozen times while it is built, mostly of none."""
        if not self.is_attached:  # the screen was closed meanwhile
            return
        keys = [
            (active.binding, active.enabled, active.tooltip)
            for active in self.screen.active_bindings.values()
            if active.binding.show
        ]
        if keys != self._drawn:
            self._drawn = keys
            await self.recompose()

    def on_mount(self) -> None:
        """Draw the keys that work from the beginning: a screen that is shown out of focus is told of no change."""
        super().on_mount()
        self.bindings_changed(self.screen)
