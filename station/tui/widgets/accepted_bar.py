"""The accepted seconds of the step; nothing here ever makes them fewer."""

from textual.content import Content

from station.tui.bars import bar
from station.tui.widgets.drawn import ValueWidget


class AcceptedBar(ValueWidget[tuple[float, float]]):
    """Value: seconds accepted, seconds wanted; wanted 0 while nothing is counted."""

    DEFAULT_CSS = """
    AcceptedBar { height: 1; }
    """

    def __init__(self) -> None:
        super().__init__((0.0, 0.0), id="accepted")

    def render(self) -> Content:
        """Draw the bar over the whole width."""
        accepted, wanted = self.value
        if not wanted:
            return Content.assemble((" ACCEPTED ", "bold"), ("no seconds are counted in this step yet", "$muted"))
        numbers = f" {accepted:.0f} of {wanted:.0f} s  {100 * accepted / wanted:3.0f} % "
        filled, empty = bar(accepted / wanted, max(self.size.width - 10 - len(numbers), 4))
        return Content.assemble(
            (" ACCEPTED ", "bold"), (filled, "$success"), (empty, "on $foreground 12%"), (numbers, "bold")
        )
