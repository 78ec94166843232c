"""The cube on the slab as characters, seen from above the south-east: north is away, to the upper right.

::

         ┌────────────────┐
        ╱      up        ╱│
       ╱                ╱ │
      ┌────────────────┐  │  N
      │                │e │ ╱
      │     south      │as╱
      └────────────────┘t╱
      down +X, north -Y, west +Z
"""

from dataclasses import dataclass

from station.tui.canvas import Canvas
from station.tui.orientation import DIRECTIONS

LEFT = 1  # columns of slab left of the cube
RIGHT = 3
SLANT = "\u2571"  # box drawings: a diagonal from corner to corner
SHADE = {"U": "60%", "S": "42%", "E": "26%"}  # of the axis's colour: the light comes from above
EDGE = "$foreground"
SLAB = "$foreground 13%"
UNKNOWN_FACE = "?"  # a face that nobody knows


@dataclass(frozen=True, slots=True)
class PictureSize:
    """Columns and rows of the front face without its edges, and how deep the cube goes back, in rows."""

    width: int
    height: int
    depth: int

    @property
    def columns(self) -> int:
        """The picture's width."""
        return self.corner + self.depth + RIGHT

    @property
    def rows(self) -> int:
        """The picture's height, with the line of hidden faces."""
        return self.bottom + 2

    @property
    def corner(self) -> int:
        """The column of the front face's right edge."""
        return LEFT + self.width + 1

    @property
    def bottom(self) -> int:
        """The row of the front face's lower edge."""
        return self.depth + self.height + 1


PICTURE_SIZES = tuple(
    PictureSize(width=4 * depth - 2, height=4 * depth // 3, depth=depth) for depth in range(3, 13)
)
SMALL, LARGE = PICTURE_SIZES[0], PICTURE_SIZES[4]


def largest_picture(columns: int, rows: int) -> PictureSize:
    """Return the largest size that fits; the smallest where none does."""
    return max(
        (s for s in PICTURE_SIZES if s.columns <= columns and s.rows <= rows), default=SMALL, key=lambda s: s.depth
    )


def draw_cube(canvas: Canvas, faces: dict[str, str], size: PictureSize, turn: str = "") -> None:
    """Draw the cube on a canvas that is at least as large as ``size`` says.

    ``faces`` look each way, as of `station.tui.orientation.faces`; `UNKNOWN_FACE` where nobody knows. ``turn``,
    ``counter-clockwise`` or ``clockwise``, adds the arrow along which the front moves, seen from above.
    """
    draw_slab(canvas, size)
    _fill(canvas, size, faces)
    _edges(canvas, size)
    _labels(canvas, size, faces)
    draw_hidden(canvas, size, faces)
    if turn:
        _arrow(canvas, size, turn)


def axis_colour(face: str) -> str:
    """Return the colour of a face such as ``-X``."""
    return "$foreground" if face == UNKNOWN_FACE else f"$axis-{face[1].lower()}"


def draw_slab(canvas: Canvas, size: PictureSize) -> None:
    """Draw the slab with its mark to the North."""
    width = LEFT + size.width + 2 + RIGHT
    for row in range(size.height, size.rows - 1):
        canvas.fill(row, size.bottom - row, width, SLAB)
    for back in range(1, size.depth):
        canvas.put(size.bottom - back, size.corner + 2 + back, SLANT, "bold $foreground")
    canvas.put(size.height + 1, size.corner + 2 + size.depth, "N", "bold $foreground")


def draw_hidden(canvas: Canvas, size: PictureSize, faces: dict[str, str]) -> None:
    """Name the faces that cannot be seen in the line below, in letters where words have no room."""
    ways = [way for way in "DNW" if faces[way] != UNKNOWN_FACE]
    words = ", ".join(f"{DIRECTIONS[way]} {faces[way]}" for way in ways)
    if len(words) > size.columns - 1:
        words = " ".join(f"{'down' if way == 'D' else way} {faces[way]}" for way in ways)
    canvas.put(size.bottom + 1, 1, words, "$foreground")


def _fill(canvas: Canvas, size: PictureSize, faces: dict[str, str]) -> None:
    shade = {way: f"{axis_colour(faces[way])} {percent}" for way, percent in SHADE.items()}
    for way in SHADE:
        if faces[way] == UNKNOWN_FACE:
            shade[way] = f"$foreground {int(SHADE[way][:-1]) // 2}%"
    for row in range(size.bottom + 1):
        back = max(size.depth - row, 0)
        canvas.fill(row, size.corner + back, _side_end(size, row) - size.corner - back + 1, shade["E"])
        way = "U" if row < size.depth else "S"
        canvas.fill(row, LEFT + back, size.width + 2, shade[way])


def _side_end(size: PictureSize, row: int) -> int:
    """Return the column of the far edge of the east face."""
    return size.corner + min(size.depth, size.bottom - row)


def _edges(canvas: Canvas, size: PictureSize) -> None:
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


def _labels(canvas: Canvas, size: PictureSize, faces: dict[str, str]) -> None:
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
        if way == "U" and size.depth < 4:  # both in one line
            canvas.put(row, column - 3, f"{faces[way]} {word}", "bold $foreground")
            continue
        if way == "E" and size.depth < 4:
            word = "E"
        canvas.put(row, column - 1, faces[way], "bold $foreground")
        canvas.put(row + 1, column - len(word) // 2, word, "$foreground")


def _arrow(canvas: Canvas, size: PictureSize, turn: str) -> None:
    line = "━" * (size.width - 2)
    arrow = f"{line}━▶" if turn == "counter-clockwise" else f"◀━{line}"
    canvas.put(size.bottom, LEFT + 1, arrow, "bold $accent")
