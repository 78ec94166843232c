"""What a screen holds of a guided calibration: the newest view, and a way to send commands."""

from typing import Protocol

from station.guide.command import OperatorCommand
from station.guide.view import CalibrationView


class CalibrationSession(Protocol):
    """An engine as its screens see it; both return at once."""

    @property
    def view(self) -> CalibrationView:
        """The newest view."""
        ...

    def send(self, command: OperatorCommand) -> None:
        """Ask something of the engine."""
        ...
