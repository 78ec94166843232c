"""How far it is, on stderr: the share that is done, samples, and the time left."""

import sys
import time
from collections.abc import Callable

EVERY_S = 1.0  # on a terminal
EVERY_LINE_S = 10.0  # elsewhere, a line each
SILENT_S = 2.0  # at the beginning


class Progress:
    """Says how far it is, now and then; ``clock`` is in s."""

    def __init__(
        self, say: Callable[[str], None] | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._is_screen = say is None and sys.stderr.isatty()
        self._say, self._clock = say or self._write, clock
        self._begin = clock()
        self._next = self._begin + SILENT_S
        self._has_said = False

    def at(self, done: float, samples: int) -> None:
        """Say that a share ``done``, 0 to 1, and so many samples are behind."""
        now = self._clock()
        if now < self._next or not done > 0:
            return
        left = (now - self._begin) * (1 / done - 1)
        self._next = now + (EVERY_S if self._is_screen else EVERY_LINE_S)
        self._has_said = True
        self._say(f"{100 * done:.0f} %, {samples} samples, {left:.0f} s left")

    def end(self) -> None:
        """End the line on a terminal."""
        if self._is_screen and self._has_said:
            sys.stderr.write("\n")

    def _write(self, text: str) -> None:
        sys.stderr.write(f"\r{text}   " if self._is_screen else f"{text}\n")
        sys.stderr.flush()
