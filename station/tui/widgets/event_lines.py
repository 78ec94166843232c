"""The last things that happened, the newest below."""

from textwrap import wrap

from textual.content import Content
from textual.geometry import Size

from station.stream.stream_events import Event, Sound
from station.tui.widgets.redrawn_on_change import ValueWidget

MIN_ROWS = 2  # rows
OUTCOME_SOUNDS: frozenset[Sound] = frozenset({"accepted", "rejected"})

SOUND_LOOKS: dict[Sound, tuple[str, str]] = {
    "": ("·", "$muted"),
    "start": ("▶", "$primary"),
    "still": ("◼", "$accent"),
    "accepted": ("✓", "$success"),
    "rejected": ("✗", "$error"),
}


class EventLines(ValueWidget[tuple[Event, ...]]):
    """As many whole events as there are lines; the newest in full colour.

    ``keeps_reason``: why the last attempt was rejected stays in sight until one is accepted.
    """

    DEFAULT_CSS = "EventLines { height: 1fr; min-height: 2; }"

    def __init__(self, *, keeps_reason: bool = False) -> None:
        super().__init__()
        self._keeps_reason = keeps_reason

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the rows that the newest event and the reason that still counts need."""
        first = self._first(self.value or ())
        return max(sum(len(_lines(each, max(width, 40), is_newest=False)) for each in first), MIN_ROWS)

    def _drawn(self, events: tuple[Event, ...]) -> Content:
        drawn, room, first = dict[int, list[Content]](), max(self.size.height, 1), self._first(events)
        for event in (*first, *(each for each in reversed(events) if each not in first)):
            lines = _lines(event, max(self.size.width, 40), is_newest=event is events[-1])
            if drawn and len(lines) > room:
                break
            drawn[event.number] = lines
            room -= len(lines)
        return Content("\n").join(line for _, lines in sorted(drawn.items()) for line in lines)

    def _first(self, events: tuple[Event, ...]) -> tuple[Event, ...]:
        """Return the newest event, and the reason of the last rejection if nothing was accepted since."""
        ends = [each for each in events if each.sound in OUTCOME_SOUNDS]
        reason = ends[-1:] if self._keeps_reason and ends and ends[-1].sound == "rejected" else []
        return events[-1:] + tuple(each for each in reason if each != events[-1])


def _lines(event: Event, width: int, *, is_newest: bool) -> list[Content]:
    symbol, colour = SOUND_LOOKS[event.sound]
    first, *others = wrap(event.text, width - 4, break_on_hyphens=False) or [""]
    look = "" if is_newest else "$muted"
    begin = Content.assemble((f" {symbol} ", f"bold {colour}"), (first, look))
    return [begin, *(Content.assemble("   ", (line, look)) for line in others)]
