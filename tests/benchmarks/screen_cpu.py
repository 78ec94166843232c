"""Print what share of one core the screens take: `python -m tests.benchmarks.screen_cpu`.

They run in a real pty of 80x24 that somebody reads. The views change 20 times a second and arrive as JSON, as
those of an engine do; the screens look at them 20 times a second.
"""

import argparse
import fcntl
import itertools
import os
import pty
import struct
import subprocess
import sys
import termios
import time

from station.guide.command import OperatorCommand
from station.guide.view import CalibrationView
from station.tui.app import StationApp
from tests.station.tui.views import HOLDING, TURNING

HZ = 20.0
SETTLED_S = 2.0  # after the start
ASKED = 30.0


class ChangingSession:
    """Shows another view each time its clock has ticked; all that moves on the screen moves."""

    def __init__(self, lines: list[bytes]) -> None:
        self._lines, self._tick, self._began = lines, -1, time.monotonic()
        self._view, self.shown = CalibrationView(), 0

    @property
    def view(self) -> CalibrationView:
        tick = int((time.monotonic() - self._began) * HZ)
        if tick != self._tick:
            self._tick, self.shown = tick, self.shown + 1
            self._view = CalibrationView.model_validate_json(self._lines[tick % len(self._lines)])
        return self._view

    def send(self, command: OperatorCommand) -> None:
        pass


def dwells(count: int = 400) -> list[bytes]:
    """Return the views of a dwell under way."""
    views = []
    for n in range(count):
        gates = HOLDING.gates.model_copy(update={"still": 1 + 0.01 * (n % 37), "off_deg": 0.3 + 0.01 * (n % 7)})
        link = HOLDING.link.model_copy(
            update={"rate_hz": 100 + 0.1 * (n % 3), "temperature_c": 24 + 0.1 * (n % 5)}
        )
        update = {"gates": gates, "link": link, "accepted_s": n / 4, "remaining_s": 2000.0 - n}
        views.append(
            HOLDING.model_copy(update=update | {"line": f"Recording position 4: {n / 4:.1f} s accepted."})
        )
    return [view.model_dump_json().encode() for view in views]


def turns(count: int = 400) -> list[bytes]:
    """Return the views of a hand turn under way."""
    views = []
    for n in range(count):
        turn = TURNING.turn.model_copy(update={"revolutions": -3 * n / count, "speed_deg_s": -30 - n % 20})
        gates = TURNING.gates.model_copy(update={"still": 400.0 + n % 90})
        views.append(
            TURNING.model_copy(update={"turn": turn, "gates": gates, "line": f"{3 * n / count:.2f} turns"})
        )
    return [view.model_dump_json().encode() for view in views]


KINDS = {"dwell": dwells, "turn": turns}


def screens(kind: str, seconds: float, report: int) -> None:
    """Run the screens in this terminal; write the share of a core they took [%] and the views shown [1/s]."""
    session = ChangingSession(KINDS[kind]())
    app = StationApp(session, refresh_hz=HZ, is_quiet=True)
    began: list[tuple[float, float, int]] = []

    def measured() -> tuple[float, float, int]:
        return time.process_time(), time.perf_counter(), session.shown

    def ended() -> None:
        (cpu0, wall0, shown0), (cpu1, wall1, shown1) = began[0], measured()
        os.write(report, f"{100 * (cpu1 - cpu0) / (wall1 - wall0)} {(shown1 - shown0) / (wall1 - wall0)}".encode())
        app.exit()

    def ready() -> None:
        app.set_timer(SETTLED_S, lambda: began.append(measured()))
        app.set_timer(SETTLED_S + seconds, ended)

    app.call_later(ready)
    app.run()


def share(kind: str, seconds: float) -> tuple[float, float, float]:
    """Return the share of a core the screens take [%], views shown [1/s], and what they write [kB/s]."""
    terminal, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    reading, writing = os.pipe()
    child = subprocess.Popen(
        [sys.executable, "-m", __spec__.name, "--kind", kind, "--seconds", str(seconds), "--report", str(writing)],
        stdin=theirs, stdout=theirs, stderr=theirs, pass_fds=(writing,), start_new_session=True,
        env=os.environ | {"TERM": "xterm-256color", "COLORTERM": "truecolor"},
    )  # fmt: skip
    os.close(theirs)
    os.close(writing)
    written = sum(map(len, _read_all(terminal)))
    child.wait()
    with os.fdopen(reading) as report:
        percent, shown = map(float, report.read().split())
    return percent, shown, written / (seconds + SETTLED_S) / 1000


def _read_all(terminal: int) -> "itertools.takewhile[bytes]":
    def read() -> bytes:
        try:
            return os.read(terminal, 65536)
        except OSError:  # the other end was closed
            return b""

    return itertools.takewhile(bool, iter(read, None))


def main() -> None:
    """Print a line per kind of view, or run the screens of one."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--report", type=int)
    options = parser.parse_args()
    if options.kind:
        return screens(options.kind, options.seconds, options.report)
    for kind in KINDS:
        percent, shown, rate = share(kind, options.seconds)
        figures = f"{shown:4.1f} views/s  {rate:5.1f} kB/s  {percent:5.1f} % of a core"
        print(f"{kind:6} 80x24  {figures}   asked {ASKED:.0f} %")
    return None


if __name__ == "__main__":
    main()
