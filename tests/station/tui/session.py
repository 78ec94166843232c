"""A session in memory, and the screens over it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from textual.pilot import Pilot

from station.guide.view import CalibrationView, OperatorCommand
from station.tui.app import StationApp

SMALL, LARGE = (80, 24), (120, 40)
PHONE = (46, 48)


class MemorySession:
    """A `station.guide.view.CalibrationSession` without an engine: holds a view, keeps what was sent."""

    def __init__(self, view: CalibrationView) -> None:
        self.view = view
        self.sent: list[OperatorCommand] = []
        self.considered: list[OperatorCommand] = []  # set-ups as they stood in the form

    def send(self, command: OperatorCommand) -> None:
        (self.considered if command.verb == "consider" else self.sent).append(command)


@dataclass(frozen=True, slots=True)
class Screens:
    """The application under test."""

    app: StationApp
    session: MemorySession
    pilot: Pilot[None]

    @property
    def sent(self) -> list[OperatorCommand]:
        return self.session.sent

    async def show(self, view: CalibrationView) -> None:
        self.session.view = view
        self.app.pull()
        await self.pilot.pause()

    async def press(self, *keys: str) -> None:
        await self.pilot.press(*keys)

    def lines(self) -> list[str]:
        """Return the text that stands in the terminal, row by row."""
        screen = self.app.screen
        strips = screen._compositor.render_strips(screen.size)  # noqa: SLF001  what is written, not what is meant
        return ["".join(segment.text for segment in strip) for strip in strips]


@asynccontextmanager
async def screens(view: CalibrationView, size: tuple[int, int] = SMALL) -> AsyncIterator[Screens]:
    """Run the application over a view; it looks at the session when it is told to, not by the clock."""
    session = MemorySession(view)
    app = StationApp(session, refresh_hz=0.001, is_quiet=True)
    async with app.run_test(size=size, notifications=True) as pilot:
        await pilot.pause()
        yield Screens(app, session, pilot)
