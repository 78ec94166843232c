"""Nothing to be done but to wait: for the IMU, or for the numbers."""

from textual.app import ComposeResult
from textual.widgets import Static

from station.guide.view import CalibrationView
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import BannerText


class WaitingScreen(FramedScreen):
    """Says what is waited for."""

    HELPS = {
        "connecting": "The station opens the port, finds the frames and identifies the unit.\n\n"
        "If no data arrive: is the IMU powered? Are port and baud rate correct?\n"
        "Are A and B of the RS-422 pair swapped? c cancels.",
        "solving": "The joint solve runs over all accepted steps. The IMU is no longer needed; all is on the "
        "disk.",
    }
    DEFAULT_CSS = "WaitingScreen #text { height: auto; padding: 1 2; }"

    def _inner(self) -> ComposeResult:
        self.text = Static(id="text", markup=False)
        yield self.text

    def _now(self, view: CalibrationView) -> BannerText:
        symbol = "∑" if view.stage == "solving" else "…"
        return BannerText(view.stage.upper(), symbol, "$primary", view.line, view.hint)

    def _draw(self, view: CalibrationView) -> None:
        if view.stage in self.HELPS:  # else the wait is over, and a modal that is open keeps this under it
            super()._draw(view)
            self.text.update(self.HELPS[view.stage])
