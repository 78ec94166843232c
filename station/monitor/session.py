"""What a screen holds of a monitor: the newest view, and a way to ask something."""

from typing import Literal, Protocol

from station.monitor.view import MonitorView

MonitorVerb = Literal[
    "mark",  # this moment, with a number
    "record",  # begin a recording, or end it
    "zero",  # show angles from here; again: absolute ones
    "anew",  # begin the comparison at rest, and the charts, anew
    "leave",
]


class MonitorSession(Protocol):
    """An engine as its screens see it; both return at once."""

    @property
    def view(self) -> MonitorView:
        """The newest view."""
        ...

    def send(self, verb: MonitorVerb) -> None:
        """Ask something of the engine."""
        ...
