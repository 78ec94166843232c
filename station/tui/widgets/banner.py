"""What is to be done now: a word, the instruction, the state in a sentence, and what comes next."""

from dataclasses import dataclass

from textual.content import Content

from station.tui.widgets.drawn import Drawn


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
        """Draw the lines; the coloured edge runs down all three."""
        now = self.value
        chip = f" {now.symbol} {now.word} " if now.word else ""
        edge = ("▌ ", now.colour)
        return Content.assemble(
            (chip, f"bold $background on {now.colour}"), ("  " if chip else " ", ""), (now.instruction, "bold"),
            ("\n", ""), edge, (now.line, ""),
            ("\n", ""), edge, (now.hint, f"bold {now.colour}"),
        )  # fmt: skip
