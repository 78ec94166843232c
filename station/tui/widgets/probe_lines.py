"""What a look at the port found, and what the GNSS receiver of the set-up says."""

from dataclasses import dataclass

from textual.content import Content

from station.guide.setup_view import PortCheck
from station.tui.widgets.redrawn_on_change import ValueWidget


@dataclass(frozen=True, slots=True)
class AddressLook:
    """The address in the form, the newest look at one, whether another is under way; ``use``: what it is good for.

    Of a receiver alone there is a ``use``.
    """

    url: str
    check: PortCheck | None
    is_under_way: bool
    use: str = ""


class LookLine(ValueWidget[AddressLook]):
    """What was found at an address: a unit with rate, errors and noise, or a place; or why there is no telling."""

    DEFAULT_CSS = """
    LookLine { text-wrap: wrap; height: auto; min-height: 1; max-height: 4; margin-left: 13; }
    LookLine#receiver { max-height: 3; }
    """

    def _drawn(self, look: AddressLook) -> Content:
        check = look.check
        if look.is_under_way:
            port, receiver = "checking the port for two seconds", "checking the receiver for a few seconds"
            return Content.styled(f"… {receiver if look.use else port}", "$muted")
        if check is None or check.url != look.url:
            said = "not checked yet: press Enter in the address, or ctrl+l" if look.url else ""
            return Content.styled(said, "$muted")
        if not check.is_good:
            return Content.styled(f"✗ {check.text}", "bold $error")
        if look.use:
            return Content.assemble(("✓ ", "bold $success"), (check.text, "bold"), f"; {look.use}")
        unit = f"{check.model or 'model unknown'} {check.serial or 'serial number unknown'}"
        rate = "" if check.rate_hz is None else f", {check.rate_hz:.1f} Hz"
        errors = f", {check.bad_frames} of {check.frames + check.bad_frames} frames bad"
        return Content.assemble(
            ("✓ ", "bold $success"), (f"{check.format}, {unit}", "bold"), f"{rate}{errors}",
            f", noise {check.noise}" if check.noise else "",
        )  # fmt: skip
