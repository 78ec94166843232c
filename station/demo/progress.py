"""The demo's progress: a line per step that is done, and on a terminal a bar below them."""

from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from station.guide.view import CalibrationView
from station.stream.stream_events import NewEvents


class DemoProgress:
    """Shows the views of a campaign while the ``with`` block lasts."""

    def __init__(self, console: Console) -> None:
        self._console, self._events = console, NewEvents()
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
        self._progress = Progress(*columns, console=console, transient=True, disable=not console.is_terminal)
        self._task = self._progress.add_task("connecting", total=None)

    def show(self, view: CalibrationView) -> None:
        """Print what was accepted or rejected, and move the bar."""
        for event in self._events.of(view.events):
            if event.sound in {"accepted", "rejected"}:
                self._console.print(event.text, highlight=False, markup=False)
        line = view.line[: self._console.width // 2]
        self._progress.update(self._task, description=line, total=len(view.steps) or None, completed=view.done)

    def busy(self, text: str) -> None:
        """Say what goes on after the campaign: beside the bar, or in a line where there is no terminal."""
        if not self._console.is_terminal:
            self._console.print(text, highlight=False, markup=False)
        self._progress.update(self._task, description=text, total=None)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._progress.stop()
