"""The stream at a glance; a red line while nothing comes that can be used."""

from textual.content import Content

from station.guide.view import LinkView
from station.text.plural import plural
from station.tui.widgets.drawn import ValueWidget

NO_DATA = "NO DATA"


class LinkLine(ValueWidget[LinkView]):
    """Rate, bad frames, lost samples, gaps, temperature."""

    DEFAULT_CSS = """
    LinkLine { text-wrap: wrap; height: auto; padding: 0 1; background: $panel; }
    LinkLine.silent { background: $error; color: $background; text-style: bold; }
    """

    def __init__(self) -> None:
        super().__init__(LinkView(), id="link")

    def show(self, value: LinkView) -> None:
        """Take a link's state."""
        self.set_class(not value.is_live, "silent")
        super().show(value)

    def render(self) -> Content:
        """Draw the numbers, or in two words what is wrong."""
        link = self.value
        if not link.is_live:
            return Content(f"✗ {link.word or NO_DATA}  {link.name}")  # the banner says the rest
        if not link.rate_hz:
            return Content.styled(
                f"… {link.name}  nothing received yet" if link.name else "… no IMU yet", "$muted"
            )
        counted = [f"{link.bad_frames} bad", f"{link.lost} lost", plural(link.gaps, "gap")]
        numbers = [f"{link.rate_hz:.1f} Hz", *counted]
        if link.temperature_c is not None:
            numbers.append(f"{link.temperature_c:.1f} °C")
        return Content.assemble(
            ("✓ live ", "bold $success"),
            f" {link.name}  ",
            "  ".join(numbers),
            (f"  {link.text}", "bold $warning"),
        )
