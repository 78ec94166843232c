"""How far the work is, on stderr: one line that is rewritten on a terminal, else a line now and then."""

import time
from collections.abc import Callable
from typing import TextIO

TERMINAL_PERIOD_S = 0.2  # a terminal needs no more
LOG_PERIOD_S = 10.0  # between lines of a log


class Progress:
    """Counts items that end, some of which were kept from an earlier run."""

    def __init__(self, stream: TextIO, title: str, total: int, now: Callable[[], float] = time.monotonic) -> None:
        self._stream, self._title, self._total, self._now = stream, title, total, now
        self._began = self._shown_at = now()
        self._done = self._kept = self._faults = 0

    def advance(self, *, was_kept: bool = False, is_fault: bool = False) -> None:
        """Count an item."""
        self._done += 1
        self._kept += was_kept
        self._faults += is_fault
        is_terminal, now = self._stream.isatty(), self._now()
        if self._done == self._total or now - self._shown_at >= (
            TERMINAL_PERIOD_S if is_terminal else LOG_PERIOD_S
        ):
            self._shown_at = now
            self._stream.write(f"\r\x1b[K{self}" if is_terminal else f"{self}\n")
            self._stream.flush()

    def end(self) -> None:
        """Take the line off a terminal."""
        if self._stream.isatty():
            self._stream.write("\r\x1b[K")
            self._stream.flush()

    def __str__(self) -> str:
        said = [f"{self._title}: {self._done} of {self._total}"]
        if self._kept:
            said.append(f"{self._kept} kept")
        if self._faults:
            said.append(f"{self._faults} refused")
        worked, left = self._done - self._kept, self._total - self._done
        if worked and left:
            seconds = (self._now() - self._began) / worked * left
            said.append(f"{seconds:.0f} s left" if seconds < 100 else f"{seconds / 60:.0f} min left")
        return ", ".join(said)
