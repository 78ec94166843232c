"""The screens in a real terminal."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.station.tui.show import SHOW


class Terminal:
    """The other end of a program's terminal."""

    def __init__(self, end: int) -> None:
        self._end, self.seen = end, b""

    def type(self, keys: bytes) -> None:
        os.write(self._end, keys)

    def wait_for(self, text: bytes) -> None:
        while text not in self.seen:
            self.seen += os.read(self._end, 65536)

    def wait_for_bells(self, bells: int) -> None:
        while self.bells < bells:
            self.seen += os.read(self._end, 65536)

    @property
    def bells(self) -> int:
        return re.sub(rb"\x1b\][^\a]*\a", b"", self.seen).count(b"\a")  # some sequences end in the same byte

    def read_to_the_end(self) -> None:
        try:
            while more := os.read(self._end, 65536):
                self.seen += more
        except OSError:  # the program has closed its end
            pass


@contextmanager
def terminal(*arguments: str) -> Iterator[tuple[Terminal, subprocess.Popen[bytes]]]:
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    program = subprocess.Popen(
        [sys.executable, "-P", "-c", SHOW, *arguments],
        stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        env=os.environ | {"TERM": "xterm-256color"},
    )  # fmt: skip
    os.close(theirs)
    try:
        yield Terminal(ours), program
    finally:
        program.kill()
        program.wait()
        os.close(ours)


@pytest.mark.parametrize(("options", "bells"), [((), 3), (("quiet",), 0)])
def test_they_ring_and_run_until_the_operator_has_left(options: tuple[str, ...], bells: int) -> None:
    with terminal("holding", *options) as (seen, program):
        seen.wait_for(b"position 3 accepted")
        seen.wait_for_bells(bells)
        seen.type(b"q")
        seen.wait_for(b"Yes, leave")
        seen.type(b"y")
        seen.wait_for(b"LEFT")
        seen.type(b"\r")
        seen.read_to_the_end()
        assert seen.bells == bells
        assert program.wait() == 0


def test_textual_is_not_imported_before_there_is_a_screen() -> None:
    program = "import sys, station.tui; sys.exit('textual' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program]).returncode == 0
