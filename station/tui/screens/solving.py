"""All is recorded; the numbers are being computed."""

from station.guide.view import CalibrationView
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import BannerText


class SolvingScreen(FramedScreen):
    """Says that it takes a moment."""

    TEXT = "The joint solve runs over all accepted steps. The IMU is no longer needed; all is on the disk."
    HELPS = {"solving": TEXT}

    def now(self, view: CalibrationView) -> BannerText:
        """Return what the banner says."""
        return BannerText("SOLVING", "∑", "$primary", view.line, view.hint)
