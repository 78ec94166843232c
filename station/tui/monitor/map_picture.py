"""A map of characters: the way gone, north up, where the unit is and which way it points, fixes that stand off."""

import math
from collections.abc import Iterable
from itertools import pairwise

from textual.content import Content

from station.locate.location import Location
from station.tui.canvas import Canvas

MIN_MAP_SPAN_M = 20.0  # m that a map shows at least
STEPS = (1, 2, 5, 10)
SCALES = (1, 1.5, 2, 3, 5, 7, 10)  # of metres to a dot, so that a map keeps its scale for a while
ARROWS = "↑↗→↘↓↙←↖"
WAY, FAR, OWN, QUIET = "$primary", "$error", "bold $accent", "$muted"
MapPlace = tuple[float, float]


def map_picture(width: int, height: int, location: Location) -> Content:
    """Draw a location into ``width`` times ``height`` characters; the last row has the scale."""
    canvas = Canvas(width, height)
    if not location.is_located:
        canvas.put(height // 2, max(width // 2 - 6, 0), "no place yet", QUIET)
        return canvas.content()
    here = location.enu[0], location.enu[1]
    sheet = _Sheet(width, height - 1, (*location.track, here))
    _way(canvas.window(0, 0, width, height - 1), sheet, (*location.track, here))
    canvas.put(*sheet.cell((0.0, 0.0)), "+", QUIET)
    for place in location.far:
        canvas.put(*sheet.cell(place), "✗", FAR)
    arrow = "●" if location.heading is None else ARROWS[round(location.heading / 45) % 8]
    canvas.put(*sheet.cell(here), arrow, OWN)
    canvas.put(0, width - 2, "N↑", QUIET)
    _scale(canvas, sheet, height - 1)
    return canvas.content()


class _Sheet:
    """Where a place East, North [m] comes to lie: eight dots to a character, as many metres each way."""

    def __init__(self, width: int, height: int, places: Iterable[MapPlace]) -> None:
        east, north = zip(*places, strict=True)
        self.columns, self.rows = 2 * width, 4 * height
        self.middle = (max(east) + min(east)) / 2, (max(north) + min(north)) / 2
        wide, tall = max(max(east) - min(east), MIN_MAP_SPAN_M), max(max(north) - min(north), MIN_MAP_SPAN_M)
        self.metres = _round_up(max(wide / (self.columns - 4), tall / (self.rows - 4)))  # to a dot

    def dot(self, place: MapPlace) -> tuple[int, int]:
        """Return row and column of its dot, which may lie outside."""
        column = self.columns / 2 + (place[0] - self.middle[0]) / self.metres
        row = self.rows / 2 - (place[1] - self.middle[1]) / self.metres
        return math.floor(row), math.floor(column)

    def cell(self, place: MapPlace) -> tuple[int, int]:
        """Return row and column of its character, outside the map where that is."""
        row, column = self.dot(place)
        is_inside = 0 <= row < self.rows and 0 <= column < self.columns
        return (row // 4, column // 2) if is_inside else (-1, -1)


def _way(canvas: Canvas, sheet: _Sheet, places: tuple[MapPlace, ...]) -> None:
    for (row, column), (to_row, to_column) in pairwise(map(sheet.dot, places)):
        steps = max(abs(to_row - row), abs(to_column - column), 1)
        for i in range(steps + 1):
            r, c = row + round(i * (to_row - row) / steps), column + round(i * (to_column - column) / steps)
            canvas.dot(r, c, WAY)


def _scale(canvas: Canvas, sheet: _Sheet, row: int) -> None:
    """Draw a bar of a round length in the last row, at most half as wide as the map."""
    metres = _round_down(sheet.metres * sheet.columns / 2)
    length = max(round(metres / sheet.metres / 2), 2)
    said = f"{metres / 1000:g} km" if metres >= 1000 else f"{metres:g} m"
    canvas.put(row, 1, "├" + "─" * (length - 2) + "┤ " + said, QUIET)


def _round_up(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in SCALES if step * power >= value * (1 - 1e-9))


def _round_down(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in reversed(STEPS) if step * power <= value * (1 + 1e-9))
