"""A grid of coloured characters to draw on."""

from itertools import groupby

from textual.content import Content

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
