"""The cube as it is to stand, or to be turned."""

from textual.content import Content

from station.guide.view import Step
from station.tui.cube_picture import LARGE, SLANT, SMALL, cube_picture
from station.tui.orientation import faces, is_counter_clockwise, start_of
from station.tui.widgets.drawn import Drawn

LEANING = f"""

        {SLANT}\u2572      on an edge
      {SLANT}    \u2572    or a corner,
    {SLANT}        \u2572  propped,
    \u2572        {SLANT}  so that it
      \u2572    {SLANT}    cannot slip
        \u2572{SLANT}"""


class Cube(Drawn[Step | None]):
    """Draws the step's start as large as there is room."""

    DEFAULT_CSS = """
    Cube { width: 35; height: 13; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="cube")

    def render(self) -> Content:
        """Draw the cube; nothing while no step is wanted."""
        step = self.value
        if step is None:
            return Content("")
        if step.is_free:
            return Content(LEANING).stylize("bold")
        size = LARGE if self.size.width > LARGE.columns and self.size.height >= LARGE.rows else SMALL
        turn = ""
        if step.axis:
            turn = "counter-clockwise" if is_counter_clockwise(step) else "clockwise"
        return cube_picture(faces(start_of(step)), size, turn)
