"""A soak: the temperature, its range so far, the time left."""

from textual.content import Content

from station.guide.view import SoakView
from station.tui.widgets.drawn import ValueWidget


class SoakLines(ValueWidget[SoakView | None]):
    """A line for the temperature, one for the time."""

    DEFAULT_CSS = """
    SoakLines { height: 3; }
    """

    def __init__(self) -> None:
        super().__init__(None, id="soak")

    def render(self) -> Content:
        """Draw what is known."""
        soak = self.value
        if soak is None:
            return Content("")
        minutes, seconds = divmod(round(soak.left_s), 60)
        said = "the device does not say it"
        if soak.temperature_c is not None:
            said = f"{soak.temperature_c:.1f} degC, so far {soak.low_c:.1f} to {soak.high_c:.1f}"
        return Content.assemble((" TEMP  ", "bold"), said, ("\n LEFT  ", "bold"), f"{minutes} min {seconds:02d} s")
