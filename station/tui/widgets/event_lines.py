"""The last things that happened, the newest below."""

from textwrap import wrap

from textual.content import Content
from textual.geometry import Size

from station.guide.view import Event, Sound
from station.tui.widgets.drawn import Drawn

LEAST = 2  # rows

LOOKS: dict[Sound, tuple[str, str]] = {
    "": ("·", "$muted"),
    "start": ("▶", "$primary"),
    "still": ("◼", "$accent"),
    "accepted": ("✓", "$success"),
    "rejected": ("✗", "$error"),
}


class EventLines(Drawn[tuple[Event, ...]]):
    """As many whole events as there are lines; the newest in full colour."""

    DEFAULT_CSS = """
    EventLines { height: 1fr; min-height: 2; }
    """

    def __init__(self) -> None:
        super().__init__((), id="events")

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the rows that the newest event needs."""
        return max(len(_lines(self.value[-1], max(width, 40), is_newest=True)) if self.value else 0, LEAST)

    def render(self) -> Content:
        """Draw the last events; what needs two lines has two."""
        rows, room = list[Content](), max(self.size.height, 1)
        for event in reversed(self.value):
            lines = _lines(event, max(self.size.width, 40), is_newest=event is self.value[-1])
            if rows and len(rows) + len(lines) > room:
                break
            rows = [*lines, *rows]
        return Content("\n").join(rows)


def _lines(event: Event, width: int, *, is_newest: bool) -> list[Content]:
    symbol, colour = LOOKS[event.sound]
    first, *others = wrap(event.text, width - 4, break_on_hyphens=False) or [""]
    look = "" if is_newest else "$muted"
    begin = Content.assemble((f" {symbol} ", f"bold {colour}"), (first, look))
    return [begin, *(Content.assemble("   ", (line, look)) for line in others)]
