"""The application: draws the session's view and sends what the operator asks. It knows nothing by itself."""

from station.monitor.view import MonitorSession, MonitorView
from station.tui.common_app import CommonApp
from station.tui.monitor.screen import MonitorScreen


class MonitorApp(CommonApp):
    """The screen of one monitor."""

    def __init__(self, session: MonitorSession, *, refresh_hz: float = 10.0, is_quiet: bool = False) -> None:
        super().__init__(refresh_hz=refresh_hz, is_quiet=is_quiet)
        self._session = session
        self._view: MonitorView | None = None
        self.monitor = MonitorScreen(session.send)

    async def on_mount(self) -> None:
        """Begin to look at the session."""
        await self.push_screen(self.monitor)
        await super().on_mount()

    def pull(self) -> None:
        """Show the session's view if it is another; close when it is over."""
        view = self._session.view
        if view is self._view:
            return
        self.ring(view.events, is_first=self._view is None)
        self._view = view
        self.monitor.show(view)
        if view.is_over:
            self.exit()
