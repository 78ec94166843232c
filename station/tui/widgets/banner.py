"""What is to be done now: a word, the instruction, the state in a sentence, and what comes next."""

from dataclasses import dataclass
from textwrap import wrap

from textual.content import Content

from station.tui.widgets.drawn import Drawn

LINES = 2  # below the instruction


@dataclass(frozen=True, slots=True)
class Now:
    """``word`` and its ``symbol`` say what is asked, ``colour`` is a variable of the theme."""

    word: str
    symbol: str
    colour: str
    instruction: str
    line: str = ""
    hint: str = ""


class Banner(Drawn[Now]):
    """Three lines that everybody must see."""

    DEFAULT_CSS = """
    Banner { height: 3; background: $surface; }
    """

    def __init__(self) -> None:
        super().__init__(Now("", "", "$primary", ""), id="banner")

    def render(self) -> Content:
        """Draw the lines: the hint is never cut off by a long sentence. The coloured edge runs down them."""
        now = self.value
        chip = f" {now.symbol} {now.word} " if now.word else ""
        hint = self._wrapped(now.hint, 1)
        line = self._wrapped(now.line, LINES - len(hint))
        edge = ("▌ ", now.colour)
        rows = [Content.assemble((chip, f"bold $background on {now.colour}"), (f"  {now.instruction}", "bold"))]
        rows += [Content.assemble(edge, row) for row in line]
        rows += [Content.assemble(edge, (row, f"bold {now.colour}")) for row in hint]
        rows += [Content.assemble(edge)] * (LINES + 1 - len(rows))
        return Content("\n").join(rows)

    def _wrapped(self, text: str, lines: int) -> list[str]:
        return wrap(
            text, max(self.content_size.width - 4, 20), max_lines=lines, placeholder=" ...", break_on_hyphens=False
        )
