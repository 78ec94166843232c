"""Run the monitor's screen in this terminal."""

from station.monitor.session import MonitorSession
from station.tui.run import REFRESH_HZ, SLOW_HZ


def run_monitor(session: MonitorSession, *, slow: bool = False, quiet: bool = False) -> None:
    """Show a monitor until it is over or the operator has left; parameters as of `station.tui.run.run_screens`."""
    from station.tui.monitor.app import MonitorApp

    MonitorApp(session, refresh_hz=SLOW_HZ if slow else REFRESH_HZ, is_quiet=quiet).run()
