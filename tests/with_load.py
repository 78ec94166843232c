"""Run a command with busy loops: `python -m tests.with_load [--loops 10] COMMAND ...`, so many for each core."""

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence

LOOP = "import os\np = os.getppid()\nwhile os.getppid() == p:\n    for _ in range(10**7): pass"


def main(arguments: Sequence[str] | None = None) -> int:
    """Return the command's exit code; the loops end with it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--loops", type=int, default=10)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    wanted = parser.parse_args(arguments)
    count = wanted.loops * (os.cpu_count() or 1)
    loops = [subprocess.Popen([sys.executable, "-c", LOOP], start_new_session=True) for _ in range(count)]
    command = subprocess.Popen(wanted.command)
    try:
        return command.wait()
    except KeyboardInterrupt:
        return command.wait()  # it was interrupted, too, and has something to say
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
        sys.stderr.write(f"load of the last minutes: {os.getloadavg()}\n")


if __name__ == "__main__":
    sys.exit(main())
