"""All is recorded; the numbers are being computed."""

from station.guide.view import View
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import Now


class SolvingScreen(FramedScreen):
    """Says that it takes a moment."""

    TEXT = "The joint solve runs over all accepted steps. The IMU is no longer needed; all is on the disk."
    HELPS = {"solving": TEXT}

    def now(self, view: View) -> Now:
        """Return what the banner says."""
        return Now("SOLVING", "∑", "$primary", view.line, view.hint)
