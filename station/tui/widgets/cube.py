"""The cube as it is to stand or to be turned, next to the cube as it stands; its orientation in words."""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, radians
from textwrap import wrap

import numpy as np
from numpy.typing import NDArray
from textual.content import Content

from procedures.positions import ATTITUDES, POSITIONS, TURN_START, face_of
from station.guide.view import PoseView, StepView
from station.tui.widgets.common import Canvas, ValueWidget

DIRECTIONS = {"U": "up", "D": "down", "N": "north", "S": "south", "E": "east", "W": "west"}
RotationRows = Sequence[Sequence[float]]
SQUARE_DEG = 10.0  # nearer a cube is drawn square to the slab
_OPPOSITE = dict(zip("UDNSEW", "DUSNWE", strict=True))


def faces(position: int) -> dict[str, str]:
    """Return the face that looks each way in position 1..24: ``{"U": "+X", "D": "-X", "E": "+Y", ...}``."""
    looks = dict[str, str]()
    for axis, letter in enumerate(ATTITUDES[position - 1]):
        looks |= _both_ways(letter, axis, is_positive=True)
    return looks


def faces_of(C_lb: RotationRows) -> dict[str, str] | None:
    """Return the face that looks each way, from what East, North and Up are along the cube's axes.

    None where the cube stands more than `SQUARE_DEG` off any way that a position can have.
    """
    looks = dict[str, str]()
    for letter, row in zip("ENU", C_lb, strict=True):
        axis = max(range(3), key=lambda i: abs(row[i]))
        if abs(row[axis]) < cos(radians(SQUARE_DEG)):
            return None
        looks |= _both_ways(letter, axis, is_positive=row[axis] > 0)
    return looks


def nearest_face(C_lb: RotationRows) -> dict[str, str]:
    """Return the face that is up and the one that is down; which way the others look is not known."""
    up = C_lb[2]
    axis = max(range(3), key=lambda i: abs(up[i]))
    return dict.fromkeys("NSEW", "?") | _both_ways("U", axis, is_positive=up[axis] > 0)


def _both_ways(letter: str, axis: int, *, is_positive: bool) -> dict[str, str]:
    """Return the face that looks where ``letter`` says, and the one that looks away from there."""
    there, away = "+-" if is_positive else "-+"
    return {letter: f"{there}{'XYZ'[axis]}", _OPPOSITE[letter]: f"{away}{'XYZ'[axis]}"}


def start_of(step: StepView) -> int:
    """Return the position, 1..24, in which a step stands or begins."""
    with_it_up = next((p for p in range(1, len(POSITIONS) + 1) if face_of(p) == step.up), 0)
    return step.position or step.start_position or with_it_up or TURN_START[step.axis]


def is_counter_clockwise(step: StepView) -> bool:
    """Return whether a turn is counter-clockwise seen from above: right-handed about the axis that points up."""
    return face_of(start_of(step)).endswith("up") == (step.direction == "+")


LEFT = 1  # columns of slab left of the cube
RIGHT = 3
SLANT = "\u2571"  # box drawings: a diagonal from corner to corner
SHADE = {"U": 60, "S": 42, "E": 26}  # % of the axis's colour: the light comes from above
EDGE = "$foreground"
SLAB = "$foreground 13%"
UNKNOWN_FACE = "?"  # a face that nobody knows


class PictureSize:
    """Columns and rows of a cube's picture; ``depth``, the rows by which it goes back, determines them all."""

    def __init__(self, depth: int) -> None:
        self.depth, self.width, self.height = depth, 4 * depth - 2, 4 * depth // 3  # of the front without edges
        self.corner, self.bottom = LEFT + self.width + 1, depth + self.height + 1  # right, lower edge of the front
        self.columns, self.rows = self.corner + depth + RIGHT, self.bottom + 2  # with the line of hidden faces


PICTURE_SIZES = tuple(map(PictureSize, range(3, 13)))
SMALL, LARGE = PICTURE_SIZES[0], PICTURE_SIZES[4]


def largest_picture(columns: int, rows: int) -> PictureSize:
    """Return the largest size that fits; the smallest where none does."""
    return [SMALL, *(s for s in PICTURE_SIZES if s.columns <= columns and s.rows <= rows)][-1]


def draw_cube(canvas: Canvas, faces: dict[str, str], size: PictureSize, turn: str = "") -> None:
    """Draw the cube on a canvas that is at least as large as ``size`` says.

    ``faces`` look each way, as of `orientation.faces`; `UNKNOWN_FACE` where nobody knows. ``turn``,
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
    unknown = {way for way in SHADE if faces[way] == UNKNOWN_FACE}
    percents = {way: percent // 2 if way in unknown else percent for way, percent in SHADE.items()}
    shade = {way: f"{axis_colour(faces[way])} {percent}%" for way, percent in percents.items()}
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
    middle, top = LEFT + 1 + size.width // 2, size.depth // 2
    for way, row, column in (
        ("U", top, middle + (size.depth - top)),
        ("S", size.depth + size.height // 2, middle),
        ("E", (size.depth + size.height) // 2, size.corner + 1 + size.depth // 2),
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


Floats = NDArray[np.float64]
SCALE = 0.8  # of the upright cube: one that stands on its edge is wider
MIN_NAME_COLUMNS = 2.5  # characters that a face needs for its name
NORTH_WEST = "\u2572"  # box drawings


def draw_turned(canvas: Canvas, C_lb: Sequence[Sequence[float]], size: PictureSize) -> None:
    """Draw a cube whose axes point, along East, North and Up, as ``C_lb`` (3, 3) says."""
    draw_slab(canvas, size)
    C = np.array(C_lb, float)
    view = np.array([size.depth / (size.width + 1), -1.0, size.depth / (size.height + 1)])  # to the onlooker
    normals = [(axis, sign) for axis in range(3) for sign in (1, -1) if sign * C[:, axis] @ view > 0]
    for axis, sign in normals:
        _face(canvas, C, axis, sign, size)
    for axis, sign in normals:
        _outline(canvas, C, axis, sign, size)
    for axis, sign in normals:
        row, column = _on_screen(sign * C[:, axis], size)
        if abs(np.linalg.det(_spans(C, axis, size))) * 4 > MIN_NAME_COLUMNS * 2:
            canvas.put(round(row), round(column) - 1, _name(axis, sign), "bold $foreground")


def _on_screen(point: Floats, size: PictureSize) -> Floats:
    """Return row and column of a point (3,) East, North, Up; the cube's faces are 1 from its middle."""
    east, north, up = SCALE * point
    half = np.array([size.height + 1, size.width + 1]) / 2
    middle = np.array([size.bottom - half[0] - size.depth / 2, LEFT + half[1] + size.depth / 2])
    back = north * size.depth / 2
    screen: Floats = middle + np.array([-up * half[0] - back, east * half[1] + back])
    return screen


def _spans(C: Floats, axis: int, size: PictureSize) -> Floats:
    """Return the half edges (2, 2) of a face on the screen, a column each: rows and columns that they go."""
    edges = [_on_screen(C[:, i], size) - _on_screen(np.zeros(3), size) for i in range(3) if i != axis]
    return np.column_stack(edges)


def _face(canvas: Canvas, C: Floats, axis: int, sign: int, size: PictureSize) -> None:
    normal, spans = sign * C[:, axis], _spans(C, axis, size)
    if abs(np.linalg.det(spans)) < 1e-6:
        return
    middle, inverse = _on_screen(normal, size), np.linalg.inv(spans)
    percent = round(26 + 34 * max(normal[2], 0) + 16 * max(-normal[1], 0))  # the light comes from above
    for row in range(size.rows - 1):
        for column in range(size.columns):
            if np.abs(inverse @ (np.array([row, column]) - middle)).max() <= 1:
                canvas.fill(row, column, 1, f"{axis_colour(_name(axis, sign))} {percent}%")


def _outline(canvas: Canvas, C: Floats, axis: int, sign: int, size: PictureSize) -> None:
    a, b = (C[:, i] for i in range(3) if i != axis)
    around = ((1, 1), (1, -1), (-1, -1), (-1, 1), (1, 1))
    corners = [_on_screen(sign * C[:, axis] + s * a + t * b, size) for s, t in around]
    for begin, end in pairwise(corners):
        rows, columns = end - begin
        steps = max(round(abs(rows)), round(abs(columns)), 1)
        mark = "─" if abs(columns) > 2 * abs(rows) else "│" if abs(rows) > 2 * abs(columns) else ""
        mark = mark or (SLANT if rows * columns < 0 else NORTH_WEST)
        for i in range(steps + 1):
            row, column = begin + (end - begin) * i / steps
            canvas.put(round(row), round(column), mark, EDGE)


def _name(axis: int, sign: int) -> str:
    return f"{'+' if sign > 0 else '-'}{'XYZ'[axis]}"


TILTED_PICTURE = f"""
   {SLANT}\u2572   on an edge
 {SLANT}    \u2572 or corner,
{SLANT}     {SLANT} propped,
 \u2572  {SLANT}   not to
   \u2572{SLANT}    slip"""
TEXT_LINES = 2
TITLES = ("TARGET", "CUBE NOW")


class CubePair(ValueWidget[tuple[StepView | None, PoseView | None]]):
    """The step that is wanted and the cube as it stands, as large as there is room; what is left to do below."""

    DEFAULT_CSS = "CubePair { width: 38; height: 1fr; }"

    def _drawn(self, value: tuple[StepView | None, PoseView | None]) -> Content:
        (width, height), (step, pose) = self.size, value
        if step is None or not width:
            return Content("")
        size = largest_picture(width // 2, height - 1 - TEXT_LINES)
        canvas = Canvas(width, height)
        for number, title in enumerate(TITLES):
            canvas.put(0, number * (width // 2) + 1, title, "bold" if number == 0 else "bold $accent")
        _wanted(canvas.window(1, 0, width // 2, size.rows), step, size)
        _stands(canvas.window(1, width // 2, width - width // 2, size.rows), pose, size)
        text = wrap(pose.text if pose else "orientation not known", max(width - 2, 20))
        for row, line in enumerate(text, size.rows + 1):
            canvas.put(row, 1, line, "bold $accent")
        return canvas.content()


def _wanted(canvas: Canvas, step: StepView, size: PictureSize) -> None:
    if step.is_free:
        for row, line in enumerate(TILTED_PICTURE.split("\n")):
            canvas.put(row, 1, line, "bold")
        return
    turn = "counter-clockwise" if step.axis and is_counter_clockwise(step) else "clockwise" if step.axis else ""
    draw_cube(canvas, faces(start_of(step)), size, turn)


def _stands(canvas: Canvas, pose: PoseView | None, size: PictureSize) -> None:
    if pose is None:
        return
    if pose.heading_std_deg is None:
        draw_cube(canvas, nearest_face(pose.C_lb), size)
    elif (looks := faces_of(pose.C_lb)) is not None:
        draw_cube(canvas, looks, size)
    else:
        draw_turned(canvas, pose.C_lb, size)
