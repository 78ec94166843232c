"""The cube as it is to stand, or to be turned, and beside it the cube as it stands."""

from textwrap import wrap

from textual.content import Content

from station.guide.view import PoseView, StepView
from station.tui.canvas import Canvas
from station.tui.cube_at_any_attitude import draw_turned
from station.tui.cube_picture import SLANT, PictureSize, draw_cube, largest_picture
from station.tui.orientation import faces, faces_of, is_counter_clockwise, nearest_face, start_of
from station.tui.widgets.redrawn_on_change import ValueWidget

LEANING = f"""
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
        for row, line in enumerate(LEANING.split("\n")):
            canvas.put(row, 1, line, "bold")
        return
    turn = ""
    if step.axis:
        turn = "counter-clockwise" if is_counter_clockwise(step) else "clockwise"
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
