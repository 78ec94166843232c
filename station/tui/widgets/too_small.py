"""What stands in a terminal that is too small for anything else."""

from textual.app import RenderResult
from textual.content import Content

from station.tui.widgets.drawn import ValueWidget

LEAST = (80, 24)  # columns, rows
GOES_ON = "The campaign goes on meanwhile, and keys work"


class TooSmall(ValueWidget[bool]):
    """Says what is needed and what there is; the screen comes back by itself once there is room.

    ``value``: whether a campaign goes on meanwhile.
    """

    DEFAULT_CSS = """
    TooSmall {
        layer: above; display: none; width: 100%; height: 100%; padding: 1 2; text-wrap: wrap;
        background: $background;
    }
    """

    def __init__(self) -> None:
        super().__init__(False)

    def render(self) -> RenderResult:
        """Draw the sentence."""
        columns, rows = self.app.size
        return Content.assemble(
            (f"needs {LEAST[0]}x{LEAST[1]}", "bold $warning"),
            f"; this terminal has {columns}x{rows}: make it larger, or its letters smaller. "
            f"{GOES_ON if self.value else 'Keys work'}. --plain does with any terminal.",
        )
