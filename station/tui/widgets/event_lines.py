"""The last things that happened, the newest below."""

from textual.content import Content

from station.guide.view import Event, Sound
from station.tui.widgets.drawn import Drawn

LOOKS: dict[Sound, tuple[str, str]] = {
    "": ("·", "$muted"),
    "start": ("▶", "$primary"),
    "still": ("◼", "$accent"),
    "accepted": ("✓", "$success"),
    "rejected": ("✗", "$error"),
}


class EventLines(Drawn[tuple[Event, ...]]):
    """As many events as there are lines; the newest in full colour."""

    DEFAULT_CSS = """
    EventLines { height: 1fr; min-height: 2; }
    """

    def __init__(self) -> None:
        super().__init__((), id="events")

    def render(self) -> Content:
        """Draw the last events."""
        seen = self.value[-max(self.size.height, 1) :]
        return Content("\n").join(_line(event, event is self.value[-1]) for event in seen)


def _line(event: Event, is_newest: bool) -> Content:
    symbol, colour = LOOKS[event.sound]
    return Content.assemble((f" {symbol} ", f"bold {colour}"), (event.text, "" if is_newest else "$muted"))
