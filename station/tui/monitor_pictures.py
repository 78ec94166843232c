"""A map of characters: the way gone, north up, where the unit is and which way it points, fixes that stand off."""

import math
from collections.abc import Iterable
from itertools import pairwise

from textual.content import Content

from station.locate.location import Location
from station.tui.widgets.common import Canvas

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
    text = f"{metres / 1000:g} km" if metres >= 1000 else f"{metres:g} m"
    canvas.put(row, 1, "├" + "─" * (length - 2) + "┤ " + text, QUIET)


def _round_up(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in SCALES if step * power >= value * (1 - 1e-9))


def _round_down(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in reversed(STEPS) if step * power <= value * (1 + 1e-9))


SPAN = 50.0  # deg of pitch from the lowest row to the highest
TALL = 2.0  # a character is about twice as high as wide
STEP = 10  # deg between two rungs of the ladder
SKY, GROUND, RUNG, WINGS = "$sky", "$ground", "$foreground 70%", "bold $accent"


def horizon_picture(width: int, height: int, roll: float, pitch: float) -> Content:
    """Draw roll and pitch [deg] into ``width`` times ``height`` characters.

    Roll to the right turns the horizon against the clock; nose up moves it down.
    """
    canvas = Canvas(width, height)
    elevation = _Elevation(width, height, roll, pitch)
    for row in range(height):
        for column in range(width):
            upper, lower = (elevation.at(column, row + part) < 0 for part in (0.25, 0.75))
            canvas.fill(row, column, 1, GROUND if upper else SKY)
            if upper != lower:
                canvas.put(row, column, "▄", GROUND if lower else SKY)
            elif lower and (row + column) % 4 == 0:  # ground also where there are no colours
                canvas.put(row, column, "·", RUNG)
    _ladder(canvas, elevation)
    _own(canvas, width, height)
    return canvas.content()


class _Elevation:
    """How high above the horizon [deg] a place of the picture is."""

    def __init__(self, width: int, height: int, roll: float, pitch: float) -> None:
        self.middle = (width / 2, height / 2)
        self.degrees = SPAN / (height * TALL)  # for the width of a character
        self.sin, self.cos, self.pitch = math.sin(math.radians(roll)), math.cos(math.radians(roll)), pitch

    def at(self, column: int, row: float) -> float:
        x, y = column + 0.5 - self.middle[0], (row - self.middle[1]) * TALL
        return self.pitch - (x * self.sin + y * self.cos) * self.degrees

    def place(self, elevation: float, along: float) -> tuple[int, int]:
        """Return row and column of what is ``elevation`` [deg] high, ``along`` characters from the middle."""
        depth = (self.pitch - elevation) / self.degrees
        x, y = depth * self.sin + along * self.cos, depth * self.cos - along * self.sin
        return math.floor(self.middle[1] + y / TALL), math.floor(self.middle[0] + x)


def _ladder(canvas: Canvas, elevation: _Elevation) -> None:
    for rung in range(-180, 181, STEP):
        if rung and abs(rung - elevation.pitch) < SPAN / 2:
            text = f"{rung if abs(rung) <= 90 else int(math.copysign(180, rung)) - rung:+d}"
            for along in (-4, -3, 3, 4):
                canvas.put(*elevation.place(rung, along), "─", RUNG)
            row, column = elevation.place(rung, 8)
            canvas.put(row, column - len(text) // 2, text, RUNG)


def _own(canvas: Canvas, width: int, height: int) -> None:
    """Draw the unit's own axes: wings and nose."""
    row, middle = height // 2, width // 2
    canvas.put(row, middle - 7, "━━━━━", WINGS)
    canvas.put(row, middle, "◆", WINGS)
    canvas.put(row, middle + 3, "━━━━━", WINGS)
