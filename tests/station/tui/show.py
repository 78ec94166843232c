"""Show a view made by hand in this terminal, with a sound: `python -m tests.station.tui.show holding`.

`SHOW` is the same as a program that tests start.
"""

import sys

from station.guide.view import CalibrationView, OperatorCommand
from station.stream.stream_events import Event
from station.tui import run_screens
from tests.paths import ROOT
from tests.station.tui.session import MemorySession
from tests.station.tui.views import LEFT, VIEWS

SHOW = f"import sys; sys.path.insert(0, {str(ROOT)!r}); from tests.station.tui.show import main; main()"
FIRST, THEN = 5, Event(number=12, sound="accepted", text="position 3 accepted")


class Showing(MemorySession):
    """Something is accepted once it was looked at a few times; leaving leaves."""

    def __init__(self, view: CalibrationView) -> None:
        super().__init__(view)
        self.looks = 0

    @property
    def view(self) -> CalibrationView:
        self.looks += 1
        if self.looks == FIRST:
            self._view = self._view.model_copy(update={"events": (*self._view.events, THEN)})
        return self._view

    @view.setter
    def view(self, view: CalibrationView) -> None:
        self._view = view

    def send(self, command: OperatorCommand) -> None:
        if command.verb == "leave":
            self._view = LEFT


def main() -> None:
    """Show the view that the first argument names."""
    run_screens(Showing(VIEWS[sys.argv[1]]), quiet="quiet" in sys.argv)


if __name__ == "__main__":
    main()
