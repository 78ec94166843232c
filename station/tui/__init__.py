"""The terminal screens: they draw a `CalibrationView` or a `MonitorView` and send commands, nothing else.

`app` shows the screen of the view's stage (`screens`), which is made of `widgets`; it shares its base with the
monitor (`monitor_screen`, `monitor_widgets`, `monitor_pictures`). `web` and `web_server` show the same in a
browser. Textual is imported only where there is a screen.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from station.guide.view import CalibrationSession
    from station.monitor.view import MonitorSession

REFRESH_HZ = 10.0
SLOW_HZ = 2.0  # a serial console at 115 200 baud carries no more


def run_screens(session: "CalibrationSession", *, slow: bool = False, quiet: bool = False) -> None:
    """Show a calibration until its campaign has ended or the operator has left.

    ``slow``: look at the view twice a second only, for a slow terminal; ``quiet``: ring no bell.
    """
    from station.tui.app import StationApp

    StationApp(session, refresh_hz=SLOW_HZ if slow else REFRESH_HZ, is_quiet=quiet).run()


def run_monitor(session: "MonitorSession", *, slow: bool = False, quiet: bool = False) -> None:
    """Show a monitor until it is over or the operator has left; parameters as of `run_screens`."""
    from station.tui.monitor_screen import MonitorApp

    MonitorApp(session, refresh_hz=SLOW_HZ if slow else REFRESH_HZ, is_quiet=quiet).run()
