"""What a screen holds of a guided calibration: the newest view, and a way to send commands."""

from typing import Protocol

from station.guide.command import Command
from station.guide.view import View


class Session(Protocol):
    """An engine as its screens see it; both return at once."""

    @property
    def view(self) -> View:
        """The newest view."""
        ...

    def send(self, command: Command) -> None:
        """Ask something of the engine."""
        ...
