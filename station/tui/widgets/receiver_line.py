"""What the GNSS receiver of the set-up says."""

from textual.content import Content

from station.guide.setup_view import PortCheck
from station.tui.widgets.drawn import ValueWidget

Heard = tuple[str, PortCheck | None, bool, bool]  # address, newest look, whether one goes on, is latitude stated


class ReceiverLine(ValueWidget[Heard]):
    """Where it stands, with sigma, and what that is for; or why there is no telling. Away without an address."""

    DEFAULT_CSS = """
    ReceiverLine { text-wrap: wrap; height: auto; min-height: 1; max-height: 3; margin-left: 13; }
    """

    def __init__(self) -> None:
        super().__init__(("", None, False, False), id="receiver")
        self.display = False

    def show(self, value: Heard) -> None:
        """Draw another value."""
        self.display = bool(value[0])
        super().show(value)

    def render(self) -> Content:
        """Draw the look, if it is of the address that stands in the form."""
        url, check, is_listening, is_stated = self.value
        use = "compared with the latitude stated" if is_stated else "what is not given below is taken from it"
        if is_listening:
            return Content.styled("… listening to the receiver for a few seconds", "$muted")
        if check is None or check.url != url:
            return Content.styled("not listened to yet: Enter in the address, or ctrl+l", "$muted")
        if not check.is_good:
            return Content.styled(f"✗ {check.text}", "bold $error")
        return Content.assemble(("✓ ", "bold $success"), (check.text, "bold"), f"; {use}")
