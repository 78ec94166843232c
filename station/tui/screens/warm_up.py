"""Warm-up: wait until the unit has settled, or skip it knowingly."""

from textual.app import ComposeResult
from textual.binding import Binding

from station.guide.view import CalibrationView
from station.tui.screens.framed import FramedScreen
from station.tui.widgets.banner import BannerText
from station.tui.widgets.warm_up_panel import WarmUpPanel


class WarmUpScreen(FramedScreen):
    """Shows how far the unit has settled."""

    HELPS = {
        "warm_up": "The IMU warms up. Leave the cube at rest on the surface plate. The positions start "
        "automatically when temperature rate and gyro drift are below limits that the station "
        "determines for this unit. If you skip the warm-up, this is recorded and uncertainties increase."
    }
    BINDINGS = [
        Binding("s", "skip", "Skip warm-up", tooltip="begin now; this is recorded, and uncertainties increase")
    ]

    def _inner(self) -> ComposeResult:
        self.panel = WarmUpPanel()
        yield self.panel

    def _now(self, view: CalibrationView) -> BannerText:
        return BannerText("WARM-UP", "◷", "$primary", view.line, view.hint)

    def _draw(self, view: CalibrationView) -> None:
        super()._draw(view)
        self.panel.show(view.warm_up)

    def action_skip(self) -> None:
        """Ask, then begin without having settled."""
        text = "This is recorded, and the uncertainties increase."
        self.confirm("Skip the warm-up?", text, "Yes, skip it", "skip_warm_up", "warm_up")
