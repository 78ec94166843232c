"""A monitor's session in memory, and the screen over it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from textual.pilot import Pilot

from station.monitor.view import MonitorVerb, MonitorView
from station.tui.monitor_screen import MonitorApp

SMALL, LARGE = (80, 24), (120, 40)


class MemorySession:
    """A `station.monitor.view.MonitorSession` without an engine: holds a view, keeps what was sent."""

    def __init__(self, view: MonitorView) -> None:
        self.view = view
        self.sent: list[MonitorVerb] = []

    def send(self, verb: MonitorVerb) -> None:
        self.sent.append(verb)


@dataclass(frozen=True, slots=True)
class Shown:
    """The application under test."""

    app: MonitorApp
    session: MemorySession
    pilot: Pilot[None]

    async def show(self, view: MonitorView) -> None:
        self.session.view = view
        self.app.pull()
        await self.pilot.pause()

    def text(self) -> str:
        """Return all that is on the terminal."""
        strips = self.app.screen._compositor.render_strips()  # noqa: SLF001
        return "\n".join("".join(part.text for part in line) for line in strips)


@asynccontextmanager
async def shown(view: MonitorView, size: tuple[int, int] = SMALL) -> AsyncIterator[Shown]:
    """Run the application over a view; it looks at the session when it is told to, not by the clock."""
    session = MemorySession(view)
    app = MonitorApp(session, refresh_hz=0.001, is_quiet=True)
    async with app.run_test(size=size, notifications=True) as pilot:
        await pilot.pause()
        yield Shown(app, session, pilot)
