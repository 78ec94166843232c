"""A cube at any attitude on the slab, in the view in which `station.tui.cube_picture` draws an upright one."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from station.tui.canvas import Canvas
from station.tui.cube_picture import EDGE, LEFT, SLANT, PictureSize, axis_colour, draw_slab

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
        a, b = (_on_screen(C[:, i], size) - _on_screen(np.zeros(3), size) for i in range(3) if i != axis)
        row, column = _on_screen(sign * C[:, axis], size)
        if abs(a[0] * b[1] - a[1] * b[0]) * 4 > MIN_NAME_COLUMNS * 2:
            canvas.put(round(row), round(column) - 1, _name(axis, sign), "bold $foreground")


def _on_screen(point: Floats, size: PictureSize) -> Floats:
    """Return row and column of a point (3,) East, North, Up; the cube's faces are 1 from its middle."""
    east, north, up = SCALE * point
    half = np.array([size.height + 1, size.width + 1]) / 2
    middle = np.array([size.bottom - half[0] - size.depth / 2, LEFT + half[1] + size.depth / 2])
    screen: Floats = middle + np.array(
        [-up * half[0] - north * size.depth / 2, east * half[1] + north * size.depth / 2]
    )
    return screen


def _face(canvas: Canvas, C: Floats, axis: int, sign: int, size: PictureSize) -> None:
    middle = _on_screen(sign * C[:, axis], size)
    a, b = (_on_screen(C[:, i], size) - _on_screen(np.zeros(3), size) for i in range(3) if i != axis)
    spans = np.column_stack((a, b))
    if abs(np.linalg.det(spans)) < 1e-6:
        return
    inverse = np.linalg.inv(spans)
    normal = sign * C[:, axis]
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
