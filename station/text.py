"""Numbers as people read them: rounded by their sigma, aligned on the decimal point.

Two significant digits of the standard uncertainty, and the value to the same place (JCGM 100:2008, 7.2.6).
"""

import math
from collections.abc import Iterable, Sequence
from io import StringIO
from typing import Literal

from rich.console import Console
from rich.table import Table

MINUS, FIGURE_SPACE, POINT_SPACE = "\u2212", "\u2007", "\u2008"
_MOST_DECIMALS = 15


def decimals(std: float) -> int:
    """Return the decimals that show two significant digits of ``std``; negative left of the point."""
    if not (math.isfinite(std) and std > 0):
        return 6
    exponent = math.floor(math.log10(float(f"{std:.1e}")))
    return min(1 - exponent, _MOST_DECIMALS)


def fixed(value: float, places: int, sign: bool = False) -> str:
    """Return a number with ``places`` decimals (left of the point where negative) and a real minus sign."""
    if not math.isfinite(value):
        return "\u2013"
    rounded = round(value, places) + 0.0  # + 0.0: no minus zero
    return f"{rounded:{'+' if sign else ''}.{max(places, 0)}f}".replace("-", MINUS)


def significant(value: float, digits: int = 2) -> str:
    """Return a number with so many significant digits, in powers of ten where it is very large or small."""
    if value == 0 or not math.isfinite(value):
        return fixed(value, 0)
    exponent = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if -5 < exponent < 6:
        return fixed(value, digits - 1 - exponent)
    return f"{fixed(value / 10.0**exponent, digits - 1)}\u00b7{power_of_ten(exponent)}"


def power_of_ten(exponent: int) -> str:
    """Return 10 with its exponent raised."""
    return f"10{str(exponent).translate(_SUPERSCRIPT)}"


def aligned(numbers: Sequence[str]) -> list[str]:
    """Return numbers padded on the right so that, set flush right in tabular figures, their points meet."""
    tails = [len(number.partition(".")[2]) for number in numbers]
    longest = max(tails, default=0)
    padded = []
    for number, tail in zip(numbers, tails, strict=True):
        point = POINT_SPACE if longest and not tail else ""
        padded.append(number + point + FIGURE_SPACE * (longest - tail))
    return padded


_SUPERSCRIPT = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")


NOT_KNOWN = "unknown"  # what a log that names neither has for model and serial number


def plural(count: int, noun: str) -> str:
    """Return ``count`` and the noun, in the plural unless it is one."""
    ending = "" if count == 1 else "es" if noun.endswith("x") else "s"
    return f"{count} {noun}{ending}"


FEW_FILES = 4  # that stand for a unit without a name


def unit_in_words(model: str, serial: str, files: Iterable[str] = ()) -> str:
    """Return model and serial number; where neither is known the few ``files`` of it, else that it has no name."""
    known = [name for name in (model, serial) if name != NOT_KNOWN] or list(files)[: FEW_FILES + 1]
    return (" " if model != NOT_KNOWN else ", ").join(known) if 0 < len(known) <= FEW_FILES else "unit not named"


WIDTH = 80


def table_lines(rows: Iterable[Sequence[str]], align: str, header: Sequence[str]) -> list[str]:
    """Return rows as indented lines of at most 80 columns; a cell that is too long continues in the next line.

    ``align`` has ``<`` for each column that is flush left and ``>`` for each that is flush right.
    """
    rows = list(rows)
    widths = [max(map(len, cells)) for cells in zip(header, *rows, strict=True)]
    between = 2 if sum(widths) + 2 * len(widths) <= WIDTH else 1
    table = Table(box=None, padding=(0, between, 0, 0), pad_edge=False)
    for side, title in zip(align, header, strict=True):
        justify: Literal["left", "right"] = "left" if side == "<" else "right"
        table.add_column(title, justify=justify, vertical="bottom", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console(
        file=StringIO(), width=WIDTH - 2, color_system=None, markup=False, emoji=False, highlight=False
    )
    with console.capture() as text:
        console.print(table)
    return [f"  {line}".rstrip() for line in text.get().splitlines()]
