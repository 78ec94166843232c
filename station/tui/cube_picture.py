"""The cube on the slab as characters, seen from above the south-east: north is away, to the upper right.

::

         ┌────────────────┐       hidden
        ╱      up        ╱│       north -Y
       ╱                ╱ │
      ┌────────────────┐  │  N
      │                │e │ ╱
      │     south      │as╱
      └────────────────┘t╱
"""

from dataclasses import dataclass

from textual.content import Content

from station.tui.canvas import Canvas
from station.tui.orientation import DIRECTIONS

LEFT = 2  # columns of slab left of the cube
RIGHT = 6
HIDDEN = "NWD"
SLANT = "\u2571"  # box drawings: a diagonal from corner to corner
SHADE = {"U": "60%", "S": "42%", "E": "26%"}  # of the axis's colour: the light comes from above
EDGE = "$foreground"
SLAB = "$foreground 13%"


@dataclass(frozen=True, slots=True)
class Size:
    """Columns and rows of the front face without its edges, and how deep the cube goes back, in rows."""

    width: int
    height: int
    depth: int

    @property
    def columns(self) -> int:
        """The picture's width, legend and all."""
        return self.legend_column + len("north -Y")

    @property
    def rows(self) -> int:
        """The picture's height."""
        return self.bottom + 2

    @property
    def corner(self) -> int:
        """The column of the front face's right edge."""
        return LEFT + self.width + 1

    @property
    def bottom(self) -> int:
        """The row of the front face's lower edge."""
        return self.depth + self.height + 1

    @property
    def legend_column(self) -> int:
        """Where the legend begins."""
        return self.corner + self.depth + 2


SMALL = Size(width=16, height=5, depth=5)
LARGE = Size(width=26, height=9, depth=7)


def cube_picture(faces: dict[str, str], size: Size, turn: str = "") -> Content:
    """Draw the cube.

    Parameters
    ----------
    faces
        The face that looks each way, as of `station.tui.orientation.faces`.
    size : Size
        How large.
    turn
        ``counter-clockwise`` or ``clockwise``: adds the arrow along which the front moves, seen from above.
    """
    canvas = Canvas(size.columns, size.rows)
    _slab(canvas, size)
    _fill(canvas, size, faces)
    _edges(canvas, size)
    _labels(canvas, size, faces)
    _legend(canvas, size, faces)
    if turn:
        _arrow(canvas, size, turn)
    return canvas.content()


def axis_colour(face: str) -> str:
    """Return the colour of a face such as ``-X``."""
    return f"$axis-{face[1].lower()}"


def _slab(canvas: Canvas, size: Size) -> None:
    width = LEFT + size.width + 2 + RIGHT
    for row in range(size.height, size.rows):
        canvas.fill(row, size.bottom - row, width, SLAB)
    for back in range(1, size.depth):
        canvas.put(size.bottom - back, size.corner + 3 + back, SLANT, "bold $foreground")
    canvas.put(size.height + 1, size.corner + 3 + size.depth, "N", "bold $foreground")


def _fill(canvas: Canvas, size: Size, faces: dict[str, str]) -> None:
    shade = {way: f"{axis_colour(faces[way])} {percent}" for way, percent in SHADE.items()}
    for row in range(size.bottom + 1):
        back = max(size.depth - row, 0)
        canvas.fill(row, size.corner + back, _side_end(size, row) - size.corner - back + 1, shade["E"])
        way = "U" if row < size.depth else "S"
        canvas.fill(row, LEFT + back, size.width + 2, shade[way])


def _side_end(size: Size, row: int) -> int:
    """Return the column of the far edge of the east face."""
    return size.corner + min(size.depth, size.bottom - row)


def _edges(canvas: Canvas, size: Size) -> None:
    far = size.corner + size.depth
    canvas.put(0, LEFT + size.depth, "┌" + "─" * size.width + "┐", EDGE)
    for row in range(1, size.bottom):
        back = size.depth - row
        if back > 0:
            canvas.put(row, LEFT + back, SLANT, EDGE)
            canvas.put(row, size.corner + back, SLANT, EDGE)
        else:
            canvas.put(row, LEFT, "│", EDGE)
            canvas.put(row, size.corner, "│", EDGE)
        canvas.put(row, _side_end(size, row), "│" if row <= size.height else SLANT, EDGE)
    canvas.put(size.height + 1, far, "┘", EDGE)
    canvas.put(size.depth, LEFT, "┌" + "─" * size.width + "┐", EDGE)
    canvas.put(size.bottom, LEFT, "└" + "─" * size.width + "┘", EDGE)


def _labels(canvas: Canvas, size: Size, faces: dict[str, str]) -> None:
    middle = LEFT + 1 + size.width // 2
    top = size.depth // 2
    front = size.depth + size.height // 2
    side = (size.depth + size.height) // 2
    for way, row, column in (
        ("U", top, middle + (size.depth - top)),
        ("S", front, middle),
        ("E", side, size.corner + 1 + size.depth // 2),
    ):
        word = DIRECTIONS[way]
        canvas.put(row, column - 1, faces[way], "bold $foreground")
        canvas.put(row + 1, column - len(word) // 2, word, "$foreground")


def _legend(canvas: Canvas, size: Size, faces: dict[str, str]) -> None:
    canvas.put(0, size.legend_column, "hidden", "$muted")
    for row, way in enumerate(HIDDEN, start=1):
        canvas.put(row, size.legend_column, DIRECTIONS[way], "bold $foreground" if way == "D" else "$foreground")
        canvas.put(row, size.legend_column + 6, faces[way], f"bold {axis_colour(faces[way])}")


def _arrow(canvas: Canvas, size: Size, turn: str) -> None:
    line = "━" * (size.width - 2)
    arrow = f"{line}━▶" if turn == "counter-clockwise" else f"◀━{line}"
    canvas.put(size.bottom + 1, LEFT + 1, arrow, "bold $accent")
