"""What is to be done now: a word, the one instruction, and why, or what hinders."""

from dataclasses import dataclass
from textwrap import wrap

from textual.content import Content

from station.tui.widgets.redrawn_on_change import ValueWidget

MIN_ROWS, MAX_ROWS = 3, 6  # rows


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
    Banner {{ height: auto; min-height: {MIN_ROWS}; max-height: {MAX_ROWS}; background: $surface; }}
    """

    def _drawn(self, now: BannerText) -> Content:
        room = max(self.content_size.width, 40)
        chip = f" {now.symbol} {now.word} " if now.word else ""
        edge = ("▌ ", now.colour)
        first, rest = _split(now.instruction, room - Content(chip).cell_length - 2)
        rows = [Content.assemble((chip, f"bold $background on {now.colour}"), (f"  {first}", "bold"))]
        rows += [Content.assemble(edge, (row, "bold")) for row in _wrapped(rest, room)]
        rows += [Content.assemble(edge, (row, f"bold {now.colour}")) for row in _wrapped(now.hint, room)]
        rows += [Content.assemble(edge)] * (MIN_ROWS - len(rows))
        return Content("\n").join(rows)


def _split(text: str, room: int) -> tuple[str, str]:
    """Return what of a text fits beside the chip, and the rest."""
    first = (wrap(text, max(room, 20), break_on_hyphens=False) or [""])[0]
    return first, text[len(first) :].strip()


def _wrapped(text: str, room: int) -> list[str]:
    return wrap(text, room - 4, break_on_hyphens=False)
