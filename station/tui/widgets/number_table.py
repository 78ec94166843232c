"""The numbers of a verdict in columns."""

from textual.content import Content

from station.guide.view import Row
from station.tui.widgets.drawn import Drawn
from station.tui.widgets.verdict_sentence import LOOKS

HEADER = ("parameter", "value", "1 sigma", "unit", "verdict", "limit", "change")
RIGHT = (1, 2, 6)  # columns of numbers


class NumberTable(Drawn[tuple[Row, ...]]):
    """As wide and high as it needs; put it where it can be scrolled."""

    DEFAULT_CSS = """
    NumberTable { width: auto; height: auto; padding: 0 2; }
    """

    def __init__(self) -> None:
        super().__init__((), id="numbers")
        self.shrink = False  # to the width of the screen

    def render(self) -> Content:
        """Draw header and rows."""
        rows = [HEADER, *(_cells(row) for row in self.value)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(HEADER))]
        colours = ["", *(_colour(row) for row in self.value)]
        return Content("\n").join(self._line(*line, widths) for line in zip(rows, colours, strict=True))

    def _line(self, cells: tuple[str, ...], colour: str, widths: list[int]) -> Content:
        aligned = [
            cell.rjust(width) if column in RIGHT else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        if cells is HEADER:
            return Content("  ".join(aligned)).stylize("bold $muted")
        verdict = HEADER.index("verdict")
        before, after = "  ".join(aligned[:verdict]), "  ".join(aligned[verdict + 1 :])
        return Content.assemble(f"{before}  ", (aligned[verdict], f"bold {colour}"), f"  {after}")


def _colour(row: Row) -> str:
    return LOOKS[row.verdict][1] if row.verdict in LOOKS else ""


def _cells(row: Row) -> tuple[str, ...]:
    symbol = LOOKS[row.verdict][0] if row.verdict in LOOKS else ""
    verdict = f"{symbol} {row.verdict.replace('_', ' ')}".strip()
    return row.name, row.value, row.sigma, row.unit, verdict, row.limit, row.change
