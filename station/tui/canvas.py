"""A grid of coloured characters to draw on."""

from itertools import groupby

from textual.content import Content

Cell = tuple[str, str, str]  # character, colour, background


class Canvas:
    """``height`` rows of ``width`` characters; what is put outside is not drawn."""

    def __init__(self, width: int, height: int) -> None:
        self._rows: list[list[Cell]] = [[(" ", "", "")] * width for _ in range(height)]

    def put(self, row: int, column: int, text: str, colour: str = "") -> None:
        """Write text over the background that is there."""
        for at, character in enumerate(text, column):
            if 0 <= row < len(self._rows) and 0 <= at < len(self._rows[row]):
                self._rows[row][at] = (character, colour, self._rows[row][at][2])

    def fill(self, row: int, column: int, width: int, background: str) -> None:
        """Empty ``width`` characters and give them a background."""
        for at in range(column, column + width):
            if 0 <= row < len(self._rows) and 0 <= at < len(self._rows[row]):
                self._rows[row][at] = (" ", "", background)

    def content(self) -> Content:
        """Return what was drawn."""
        return Content("\n").join(_line(row) for row in self._rows)


def _line(row: list[Cell]) -> Content:
    runs = groupby(row, key=lambda cell: cell[1:])
    return Content.assemble(*(("".join(c[0] for c in cells), _style(*key)) for key, cells in runs))


def _style(colour: str, background: str) -> str:
    return f"{colour} on {background}".strip() if background else colour
