"""How ready a campaign is: its two consequences below the form, and a line of the list behind them."""

from textwrap import wrap

from textual.content import Content

from station.guide.setup_view import Readiness, ReadyLine
from station.tui.widgets.redrawn_on_change import ValueWidget

WIDTH, INDENT = 68, 12  # of a line in the list
READY_LOOKS = {"ready": ("✓", "$success"), "note": ("·", "$foreground"), "lacks": ("✗", "$warning")}


class ReadyLines(ValueWidget[Readiness]):
    """Two lines: can it end in PASS, can it end in a certificate, and why not."""

    DEFAULT_CSS = "ReadyLines { height: 2; padding: 0 2; }"

    def _drawn(self, ready: Readiness) -> Content:
        return Content("\n").join(consequences(ready, self.content_size.width))


def consequences(ready: Readiness, width: int | None = None) -> list[Content]:
    """Return how the campaign can end, a line each; a reason longer than ``width`` is only pointed to."""
    states = {True: "ready", False: "lacks", None: "note"}
    answers = zip((ready.can_pass, ready.can_certify), ready.said, strict=True)
    return [_styled(states[answer], _fitting(text, width)) for answer, text in answers]


def _fitting(text: str, width: int | None) -> str:
    if width is None or len(text) + 2 <= width:
        return text
    return f"{text.partition(', ')[0]}, ctrl+r for details"


def ready_line(one: ReadyLine) -> Content:
    """Return a thing that is needed, its state as symbol and colour, and what is known of it."""
    rows = wrap(one.text, WIDTH - INDENT, break_on_hyphens=False)
    return _styled(one.state, f"{one.name:{INDENT - 2}}" + f"\n{' ' * INDENT}".join(rows))


def _styled(state: str, text: str) -> Content:
    symbol, colour = READY_LOOKS[state]
    return Content.assemble((f"{symbol} ", f"bold {colour}"), text)
