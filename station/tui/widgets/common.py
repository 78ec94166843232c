"""Widgets of every screen: the base of all, title, banner, events, keys; bars, durations, a canvas to draw on."""

from dataclasses import dataclass
from itertools import groupby
from textwrap import wrap
from typing import Generic, TypeVar

from textual.app import ComposeResult
from textual.content import Content
from textual.geometry import Size
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Footer

from station.stream.stream_events import Event, Sound

T = TypeVar("T")


class ValueWidget(Widget, Generic[T]):
    """Holds ``value``; a subclass says in `_drawn` how it looks. What is too long is cut unless it wraps."""

    DEFAULT_CSS = "ValueWidget { text-wrap: nowrap; text-overflow: ellipsis; }"

    def __init__(self, value: T | None = None, *, id: str | None = None) -> None:
        super().__init__(id=id)
        self.value = value

    def show(self, value: T | None) -> None:
        """Draw another value."""
        if value != self.value:
            self.value = value
            self.refresh(layout=self.styles.auto_dimensions)

    def render(self) -> Content:
        return Content("") if self.value is None else self._drawn(self.value)

    def _drawn(self, value: T) -> Content:
        """Return how a value looks."""
        raise NotImplementedError


_EIGHTHS = " ▏▎▍▌▋▊▉"


def bar(fraction: float, width: int, colour: str) -> Content:
    """Return a bar ``width`` characters long; ``fraction`` beyond 0..1 is cut."""
    eighths = round(min(max(fraction, 0.0), 1.0) * width * 8)
    full, part = divmod(eighths, 8)
    filled = "█" * full + (_EIGHTHS[part] if part else "")
    return Content.assemble((filled, colour), (" " * (width - len(filled)), "on $foreground 12%"))


def pointer(fraction: float, width: int) -> str:
    """Return a scale of ``width`` characters with a mark at ``fraction`` of it."""
    at = round(min(max(fraction, 0.0), 1.0) * (width - 1))
    return "─" * at + "◆" + "─" * (width - 1 - at)


def duration_in_words(seconds: float) -> str:
    """Return a time [s] in words: ``45 s``, ``12 min``, ``1 h 05 min``."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02} min"


def against_limit(value: float, limit: float, unit: str) -> str:
    """Return a value with its limit: ``0.3 < 3 deg``."""
    form = ".1f" if abs(value) < 100 else ".0f"
    return f"{value:{form}} {'>' if abs(value) > limit else '<'} {limit:g} {unit}".rstrip()


class TitleBar(ValueWidget[tuple[str, str]]):
    """What it is about on the left, how far it is on the right."""

    DEFAULT_CSS = "TitleBar { height: 1; padding: 0 1; background: $panel; color: $foreground; }"

    def _drawn(self, value: tuple[str, str]) -> Content:
        left, right = value
        room = self.size.width - len(right) - 2
        return Content.assemble((left[:room].ljust(room) + "  ", "bold"), right)


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
        """Draw the keys again if they have changed."""
        self._bindings_ready = True
        if self.is_attached and screen is self.screen:
            self.call_after_refresh(self._draw_others)

    async def _draw_others(self) -> None:
        """Draw the keys; a screen reports a change a dozen times while it is built, mostly without one."""
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
        """Draw the keys from the beginning: a screen that is shown out of focus gets no event of a change."""
        super().on_mount()
        self.bindings_changed(self.screen)


MIN_BANNER_ROWS, MAX_BANNER_ROWS = 3, 6  # rows


@dataclass(frozen=True, slots=True)
class BannerText:
    """``word`` and its ``symbol`` say what is asked, ``colour`` is a variable of the theme."""

    word: str
    symbol: str
    colour: str
    instruction: str
    hint: str = ""


class Banner(ValueWidget[BannerText]):
    """What everybody must see: nothing of it is cut off, it takes the rows that it needs."""

    DEFAULT_CSS = f"""
    Banner {{ height: auto; min-height: {MIN_BANNER_ROWS}; max-height: {MAX_BANNER_ROWS}; background: $surface; }}
    """

    def _drawn(self, now: BannerText) -> Content:
        room = max(self.content_size.width, 40)
        chip = f" {now.symbol} {now.word} " if now.word else ""
        edge = ("▌ ", now.colour)
        first, rest = _split(now.instruction, room - Content(chip).cell_length - 2)
        rows = [Content.assemble((chip, f"bold $background on {now.colour}"), (f"  {first}", "bold"))]
        rows += [Content.assemble(edge, (row, "bold")) for row in _wrapped(rest, room)]
        rows += [Content.assemble(edge, (row, f"bold {now.colour}")) for row in _wrapped(now.hint, room)]
        rows += [Content.assemble(edge)] * (MIN_BANNER_ROWS - len(rows))
        return Content("\n").join(rows)


def _split(text: str, room: int) -> tuple[str, str]:
    """Return what of a text fits next to the chip, and the rest."""
    first = (wrap(text, max(room, 20), break_on_hyphens=False) or [""])[0]
    return first, text[len(first) :].strip()


def _wrapped(text: str, room: int) -> list[str]:
    return wrap(text, room - 4, break_on_hyphens=False)


MIN_EVENT_ROWS = 2  # rows
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
        return max(sum(len(_lines(each, max(width, 40), is_newest=False)) for each in first), MIN_EVENT_ROWS)

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


DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of U+2800, by row and column
EMPTY_BRAILLE = 0x2800
Cell = tuple[str, str, str]  # character, colour, background


class Canvas:
    """``height`` rows of ``width`` characters; what is put outside is not drawn."""

    def __init__(self, width: int, height: int) -> None:
        self._rows: list[list[Cell]] = [[(" ", "", "")] * width for _ in range(height)]
        self._top = self._left = 0
        self.width, self.height = width, height

    def window(self, row: int, column: int, width: int, height: int) -> "Canvas":
        """Return a part of this one as a canvas of its own."""
        part = Canvas(0, 0)
        part._rows, part._top, part._left = self._rows, self._top + row, self._left + column
        part.width, part.height = min(width, self.width - column), min(height, self.height - row)
        return part

    def put(self, row: int, column: int, text: str, colour: str = "") -> None:
        """Write text over the background that is there."""
        for at, character in enumerate(text, column):
            if self._has(row, at):
                cells = self._rows[self._top + row]
                cells[self._left + at] = (character, colour, cells[self._left + at][2])

    def dot(self, row: int, column: int, colour: str) -> None:
        """Add a dot, of which four rows of two make a character; all that meet there get the colour."""
        if self._has(row // 4, column // 2):
            there = ord(self._rows[self._top + row // 4][self._left + column // 2][0])
            bits = max(there, EMPTY_BRAILLE) | DOTS[row % 4][column % 2]
            self.put(row // 4, column // 2, chr(bits), colour)

    def fill(self, row: int, column: int, width: int, background: str) -> None:
        """Empty ``width`` characters and give them a background."""
        first, end = max(column, 0), min(column + width, self.width)
        if 0 <= row < self.height and first < end:
            here = slice(self._left + first, self._left + end)
            self._rows[self._top + row][here] = [(" ", "", background)] * (end - first)

    def content(self) -> Content:
        """Return what was drawn."""
        return Content("\n").join(map(_line, self._rows))

    def _has(self, row: int, column: int) -> bool:
        return 0 <= row < self.height and 0 <= column < self.width


def _line(row: list[Cell]) -> Content:
    parts = []
    for (colour, background), cells in groupby(row, key=lambda cell: cell[1:]):
        style = f"{colour} on {background}".strip() if background else colour
        parts.append(("".join(cell[0] for cell in cells), style))
    return Content.assemble(*parts)
