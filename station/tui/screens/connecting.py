"""Waiting for the IMU."""

from station.guide.view import CalibrationView
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import BannerText


class ConnectingScreen(FramedScreen):
    """Says what is waited for."""

    TEXT = (
        "The station opens the port, finds the frames and reads which unit it is.\n\n"
        "If nothing comes: is the IMU powered? Is it this port, and this baud rate?\n"
        "Are A and B of the RS-422 pair swapped? c cancels."
    )
    HELPS = {"connecting": TEXT}

    def now(self, view: CalibrationView) -> BannerText:
        """Return what the banner says."""
        return BannerText("CONNECTING", "…", "$primary", view.line, view.hint)
