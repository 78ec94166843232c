"""What a look at the port found, and what the GNSS receiver of the set-up says."""

from textual.content import Content

from station.guide.setup_view import PortCheck
from station.tui.widgets.redrawn_on_change import ValueWidget

PortLook = tuple[str, PortCheck | None, bool]  # address in the form, newest check, whether one is under way
ReceiverLook = tuple[str, PortCheck | None, bool, bool]  # the same, and whether the latitude is stated


class CheckLine(ValueWidget[PortLook]):
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
            return _not_yet(url)
        if not check.is_good:
            return _refused(check)
        unit = f"{check.model or 'model unknown'} {check.serial or 'serial number unknown'}"
        rate = "" if check.rate_hz is None else f", {check.rate_hz:.1f} Hz"
        errors = f", {check.bad_frames} of {check.frames + check.bad_frames} frames bad"
        return Content.assemble(
            ("✓ ", "bold $success"), (f"{check.format}, {unit}", "bold"), f"{rate}{errors}",
            f", noise {check.noise}" if check.noise else "",
        )  # fmt: skip


class ReceiverLine(ValueWidget[ReceiverLook]):
    """Where it stands, with sigma, and what that is for; or why there is no telling. Away without an address."""

    DEFAULT_CSS = """
    ReceiverLine { text-wrap: wrap; height: auto; min-height: 1; max-height: 3; margin-left: 13; }
    """

    def __init__(self) -> None:
        super().__init__(("", None, False, False), id="receiver")
        self.display = False

    def show(self, value: ReceiverLook) -> None:
        """Draw another value."""
        self.display = bool(value[0])
        super().show(value)

    def render(self) -> Content:
        """Draw the look, if it is of the address that stands in the form."""
        url, check, is_listening, is_stated = self.value
        use = "compared with the latitude stated" if is_stated else "it fills in what is left empty below"
        if is_listening:
            return Content.styled("… listening to the receiver for a few seconds", "$muted")
        if check is None or check.url != url:
            return _not_yet(url)
        if not check.is_good:
            return _refused(check)
        return Content.assemble(("✓ ", "bold $success"), (check.text, "bold"), f"; {use}")


def _not_yet(url: str) -> Content:
    return Content.styled("not checked yet: Enter in the address, or ctrl+l" if url else "", "$muted")


def _refused(check: PortCheck) -> Content:
    return Content.styled(f"✗ {check.text}", "bold $error")
