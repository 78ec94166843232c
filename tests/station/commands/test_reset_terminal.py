"""A terminal that a killed screen left raw and in its second screen is restored."""

import os
import subprocess
import sys
import termios
import tty

PROGRAM = "import sys; from station.cli import run; raise SystemExit(run(['reset-terminal']))"


def test_a_terminal_is_as_it_was_before_a_screen() -> None:
    controller, terminal = os.openpty()
    try:
        tty.setraw(terminal)
        done = subprocess.run(
            [sys.executable, "-P", "-c", PROGRAM],
            stdin=terminal,
            stdout=terminal,
            stderr=subprocess.PIPE,
            check=False,
        )
        reported = os.read(controller, 65536).decode()
        flags = termios.tcgetattr(terminal)
    finally:
        os.close(terminal)
        os.close(controller)
    assert done.returncode == 0, done.stderr
    for sequence in ("\x1b[?1049l", "\x1b[?25h", "\x1b[?1000l", "\x1b[?1006l", "\x1b[?2004l"):
        assert sequence in reported
    wanted = termios.ECHO | termios.ICANON | termios.ISIG
    assert flags[3] & wanted == wanted
    assert flags[0] & termios.ICRNL
