"""Lines of dots: eight to a character, the newest on the right."""

import math
from collections.abc import Sequence

DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of U+2800, by row and column
EMPTY_BRAILLE = 0x2800


def line_dots(
    values: Sequence[float], width: int, height: int, low: float, high: float, span: int
) -> list[list[int]]:
    """Return the dots (height, width) of the last ``span`` values between ``low`` and ``high``; nan is left out.

    A column of dots goes from the least to the greatest of its share of the values, so that no peak is lost.
    """
    cells = [[0] * width for _ in range(height)]
    columns, rows = 2 * width, 4 * height
    shown = list(values)[-span:]
    offset = span - len(shown)
    shares: dict[int, list[float]] = {}
    for i, value in enumerate(shown):
        if math.isfinite(value):
            shares.setdefault((offset + i) * columns // span, []).append(value)
    for column, share in shares.items():
        top, bottom = (_row(value, low, high, rows) for value in (max(share), min(share)))
        for row in range(top, bottom + 1):
            cells[row // 4][column // 2] |= DOTS[row % 4][column % 2]
    return cells


def drawn_range(values: Sequence[float], least: float) -> tuple[float, float] | None:
    """Return the range to draw, at least ``least`` wide; None where nothing is known."""
    known = [value for value in values if math.isfinite(value)]
    if not known:
        return None
    low, high = min(known), max(known)
    more = max(least - (high - low), 0.0) / 2
    return low - more, high + more


def _row(value: float, low: float, high: float, rows: int) -> int:
    share = (high - value) / (high - low) if high > low else 0.5
    return min(max(math.floor(share * rows), 0), rows - 1)
