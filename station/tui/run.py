"""Run the screens in this terminal."""

from station.guide.session import CalibrationSession

REFRESH_HZ = 10.0
SLOW_HZ = 2.0  # a serial console at 115 200 baud carries no more


def run_screens(session: CalibrationSession, *, slow: bool = False, quiet: bool = False) -> None:
    """Show a session until its campaign has ended or the operator has left.

    Parameters
    ----------
    session : Session
        The engine's side.
    slow
        Look at the view twice a second only, for a slow terminal.
    quiet
        Ring no bell.
    """
    from station.tui.app import StationApp  # Textual is imported only where there is a screen

    StationApp(session, refresh_hz=SLOW_HZ if slow else REFRESH_HZ, is_quiet=quiet).run()
