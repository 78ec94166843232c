"""An artificial horizon of characters: sky and ground as seen looking forward, the unit's own axes fixed."""

import math

from textual.content import Content

from station.tui.canvas import Canvas

SPAN = 50.0  # deg of pitch from the lowest row to the highest
TALL = 2.0  # a character is about twice as high as wide
STEP = 10  # deg between two rungs of the ladder
SKY, GROUND, RUNG, OWN = "$sky", "$ground", "$foreground 70%", "bold $accent"


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
            said = f"{rung if abs(rung) <= 90 else int(math.copysign(180, rung)) - rung:+d}"
            for along in (-4, -3, 3, 4):
                canvas.put(*elevation.place(rung, along), "─", RUNG)
            row, column = elevation.place(rung, 8)
            canvas.put(row, column - len(said) // 2, said, RUNG)


def _own(canvas: Canvas, width: int, height: int) -> None:
    """Draw the unit's own axes: wings and nose."""
    row, middle = height // 2, width // 2
    canvas.put(row, middle - 7, "━━━━━", OWN)
    canvas.put(row, middle, "◆", OWN)
    canvas.put(row, middle + 3, "━━━━━", OWN)
