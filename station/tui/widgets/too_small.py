"""What stands in a terminal that is too small for anything else."""

from textual.app import RenderResult
from textual.content import Content
from textual.widget import Widget

LEAST = (80, 24)  # columns, rows


class TooSmall(Widget):
    """Says what is needed and what there is; the screen comes back by itself once there is room."""

    DEFAULT_CSS = """
    TooSmall {
        layer: above; display: none; width: 100%; height: 100%; padding: 1 2; text-wrap: wrap;
        background: $background;
    }
    """

    def render(self) -> RenderResult:
        """Draw the sentence."""
        columns, rows = self.app.size
        return Content.assemble(
            (f"needs {LEAST[0]}x{LEAST[1]}", "bold $warning"),
            f"; this terminal has {columns}x{rows}: make it larger, or its letters smaller. "
            "The campaign goes on meanwhile, and keys work. --plain does with any terminal.",
        )
