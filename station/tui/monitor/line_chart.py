"""Lines of dots: eight to a character, the newest on the right."""

import math
from collections.abc import Sequence


def line_dots(
    values: Sequence[float], width: int, height: int, low: float, high: float, span: int
) -> list[tuple[int, int]]:
    """Return row and column of the dots of the last ``span`` values between ``low`` and ``high``; nan is left out.

    ``width`` and ``height`` are in dots. A column goes from the least to the greatest of its share of the values,
    so that no peak is lost.
    """
    shown = list(values)[-span:]
    shares: dict[int, list[float]] = {}
    for i, value in enumerate(shown, span - len(shown)):
        if math.isfinite(value):
            shares.setdefault(i * width // span, []).append(value)
    return [
        (row, column)
        for column, share in shares.items()
        for row in range(_row(max(share), low, high, height), _row(min(share), low, high, height) + 1)
    ]


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
