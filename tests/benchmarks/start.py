"""How much processor time passes until the first screen stands: ``python -m tests.benchmarks.start``.

`station calibrate` on a terminal of 80x24, with a configuration and a database of its own; what counts is the
processor time of the program and of the engine that it starts, from their beginning until the form is drawn whole.
The wall clock says what the machine was doing meanwhile, so it is printed and not judged.
"""

import fcntl
import os
import pty
import re
import select
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Sequence
from pathlib import Path

FORM = ("NEW campaign", "Begin", "Latitude", "Turns")
LIMIT_S = 1.0
ASKED = 5
TICK_HZ = os.sysconf("SC_CLK_TCK")
ESCAPES = re.compile(rb"\x1b(\[[0-9;?]*[a-zA-Z]|\][^\a]*\a|P[^\x1b]*\x1b\\|.)")
PROGRAM = [sys.executable, "-P", "-c", "from station.cli import main; main()"]


def processor_s(process: int) -> float:
    """Return the processor time [s] of a process and of all its descendants, living or waited for."""
    stat = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    own = sum(map(int, stat[11:15])) / TICK_HZ  # proc(5): utime, stime, and of children waited for
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return own + sum(processor_s(int(child)) for child in children)


def until_shown(
    folder: str, *arguments: str, wanted: tuple[str, ...] = FORM, program: Sequence[str] = PROGRAM
) -> tuple[float, float]:
    """Start ``station ARGUMENTS`` on a terminal; return processor and wall time [s] until all of a text stands.

    Configuration and database are in ``folder``.
    """
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    own = {"STATION_CONFIG": f"{folder}/conf", "STATION_DB": f"{folder}/s.db", "TERM": "xterm-256color"}
    began = time.monotonic()
    started = subprocess.Popen(
        [*program, *arguments], stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        env=os.environ | own,
    )  # fmt: skip
    os.close(theirs)
    seen = b""
    try:
        while not all(text.encode() in ESCAPES.sub(b"", seen) for text in wanted):
            if not select.select([ours], [], [], 60.0)[0]:
                raise SystemExit(f"not shown within 60 s: {ESCAPES.sub(b'', seen)[-2000:]!r}")
            seen += os.read(ours, 65536)
        return processor_s(started.pid), time.monotonic() - began
    finally:
        os.killpg(started.pid, signal.SIGTERM)
        started.wait()
        os.close(ours)


def main() -> None:
    """Print the median of some starts; the first one, which also makes the database, is not among them."""
    with tempfile.TemporaryDirectory() as folder:
        until_shown(folder, "calibrate")
        found = [until_shown(folder, "calibrate") for _ in range(ASKED)]
    processor, wall = (statistics.median(values) for values in zip(*found, strict=True))
    print(f"first screen: {processor:.2f} s of processor time (asked: {LIMIT_S:g}), {wall:.2f} s on this machine")
    sys.exit(processor > LIMIT_S)


if __name__ == "__main__":
    main()
