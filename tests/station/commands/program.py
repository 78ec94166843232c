"""The program as a process of its own, its output read line by line; a command within this process."""

import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from types import TracebackType

from station import cli

# A shell starts what it runs in the background with Ctrl-C ignored; a program under test must react to it.
INTERRUPTIBLE = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
STATION = f"{INTERRUPTIBLE}; from station.cli import main; main()"


def quietly(*arguments: object) -> tuple[int, str]:
    """Run a command in this process; return its exit code and what it says on stderr."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as reported:
        return cli.run([str(one) for one in arguments]), reported.getvalue()


class Program:
    """``station ARGUMENTS``; ended when the block is left."""

    def __init__(self, *arguments: str) -> None:
        self._arguments = arguments

    def __enter__(self) -> "Program":
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", STATION, *self._arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        self.process.kill()
        self.process.communicate()

    def until(self, text: str) -> list[str]:
        """Return the lines up to one that holds ``text``."""
        assert self.process.stdout is not None
        lines = list[str]()
        for line in self.process.stdout:
            lines.append(line)
            if text in line:
                return lines
        raise AssertionError(f"no {text!r} in {lines}; it said {self.process.communicate()[1]}")

    def press(self, key: str) -> None:
        """Give it a line of input."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{key}\n")
        self.process.stdin.flush()

    def end(self) -> tuple[int, str, str]:
        """Return exit code and what is still said on stdout and stderr."""
        out, error = self.process.communicate()
        return self.process.returncode, out, error
