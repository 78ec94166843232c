"""What a look at the port found."""

from textual.content import Content

from station.guide.setup_view import PortCheck
from station.tui.widgets.drawn import ValueWidget

Look = tuple[str, PortCheck | None, bool]  # address in the form, newest check, whether one is under way


class CheckLine(ValueWidget[Look]):
    """Format, unit, rate, errors and noise; or why there is no telling."""

    DEFAULT_CSS = """
    CheckLine { text-wrap: wrap; height: auto; min-height: 1; max-height: 4; margin-left: 13; }
    """

    def __init__(self) -> None:
        super().__init__(("", None, False), id="check")

    def render(self) -> Content:
        """Draw the check, if it is of the address that stands in the form."""
        url, check, is_checking = self.value
        if is_checking:
            return Content.styled("… looking at the port for two seconds", "$muted")
        if check is None or check.url != url:
            return Content.styled("not looked at yet: Enter in the address, or ctrl+l" if url else "", "$muted")
        if not check.is_good:
            return Content.styled(f"✗ {check.text}", "bold $error")
        unit = f"{check.model or 'model not said'} {check.serial or 'serial not said'}"
        rate = "" if check.rate_hz is None else f", {check.rate_hz:.1f} Hz"
        errors = f", {check.bad_frames} of {check.frames + check.bad_frames} frames bad"
        return Content.assemble(
            ("✓ ", "bold $success"), (f"{check.format}, {unit}", "bold"), f"{rate}{errors}",
            f", noise {check.noise}" if check.noise else "",
        )  # fmt: skip
