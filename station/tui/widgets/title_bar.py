"""The top line of a screen."""

from textual.content import Content

from station.tui.widgets.redrawn_on_change import ValueWidget


class TitleBar(ValueWidget[tuple[str, str]]):
    """What it is about on the left, how far it is on the right."""

    DEFAULT_CSS = "TitleBar { height: 1; padding: 0 1; background: $panel; color: $foreground; }"

    def _drawn(self, value: tuple[str, str]) -> Content:
        left, right = value
        room = self.size.width - len(right) - 2
        return Content.assemble((left[:room].ljust(room) + "  ", "bold"), right)
