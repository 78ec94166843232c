"""How the cube stands: its heading, and whether it sits well on the slab."""

from textwrap import fill

from textual.content import Content

from station.guide.view import GatesView
from station.tui.widgets.drawn import ValueWidget


class SeatingLines(ValueWidget[GatesView | None]):
    """Heading, then seating."""

    DEFAULT_CSS = """
    SeatingLines { height: 1fr; min-height: 3; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="seating")

    def render(self) -> Content:
        """Draw what is known."""
        gates = self.value
        if gates is None:
            return Content("")
        lines = []
        if gates.heading:
            where = f"position {gates.position}, " if gates.position else ""
            said = fill(f"{where}{gates.heading}", max(self.size.width - 8, 20)).replace("\n", "\n       ")
            lines.append(Content.assemble((" NORTH ", "bold"), said))
        if gates.seating:
            symbol, colour = ("✓", "$success") if gates.is_seated else ("✗", "$error")
            said = fill(f"{symbol} {gates.seating}", max(self.size.width - 9, 20)).replace("\n", "\n         ")
            lines.append(Content.assemble((" SEAT  ", "bold"), (said, f"bold {colour}")))
        return Content("\n").join(lines)
