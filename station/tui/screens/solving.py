"""All is recorded; the numbers are being computed."""

from textual.app import ComposeResult
from textual.widgets import Static

from station.guide.view import View
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import Now

TEXT = "The joint solve runs over all accepted steps. The IMU is no longer needed; all recordings are on the disk."


class SolvingScreen(FramedScreen):
    """Says that it takes a moment."""

    HELPS = {"solving": TEXT}
    DEFAULT_CSS = """
    SolvingScreen #text { height: auto; padding: 1 2; }
    """

    def inner(self) -> ComposeResult:
        """Lay out the text."""
        yield Static(TEXT, id="text", markup=False)

    def now(self, view: View) -> Now:
        """Return what the banner says."""
        return Now("SOLVING", "∑", "$primary", "from counts to a calibration", view.line, view.hint)
