"""Progress as text: one line that is rewritten on a terminal, a line per event elsewhere."""

import sys
from typing import TextIO

from procedures.frames import POSITIONS
from procedures.steps import Dwell, Step
from station.benches.progress import Phase, Progress

_WORDS: dict[Phase, str] = {
    "place": "place",
    "settle": "settling",
    "dwell": "recording",
    "turn": "turning",
    "accepted": "accepted",
    "redo": "again",
}


class ConsoleProgress:
    """Writes what a bench says; ``total`` is the number of steps."""

    def __init__(self, total: int, out: TextIO | None = None) -> None:
        self._total = total
        self._out = sys.stdout if out is None else out
        self._is_terminal = self._out.isatty()
        self._accepted = 0
        self._said = ""

    @property
    def accepted(self) -> int:
        """How many steps were accepted."""
        return self._accepted

    def __call__(self, progress: Progress) -> None:
        """Take a bench's progress."""
        at = min(self._accepted + 1, self._total)
        line = f"[{at:2}/{self._total}] {_title(progress.step)}  {_state(progress)}"
        if progress.phase == "accepted":
            self._accepted += 1
            self._end(line)
        elif self._is_terminal:
            self._out.write(f"\r\x1b[K{line}")
            self._out.flush()
        elif progress.note and (told := f"{progress.step.name} {progress.note}") != self._said:
            self._said = told
            if progress.phase != "settle" or "expected" in progress.note:
                self._end(line)

    def say(self, line: str) -> None:
        """Write a line of its own."""
        self._end(line)

    def _end(self, line: str) -> None:
        self._out.write(f"\r\x1b[K{line}\n" if self._is_terminal else f"{line}\n")
        self._out.flush()


def _title(step: Step) -> str:
    if isinstance(step, Dwell):
        return f"position {step.position:2} {POSITIONS[step.position - 1]}"
    return f"turn {step.axis} {step.direction} {step.revolutions} rev"


def _state(progress: Progress) -> str:
    word = _WORDS[progress.phase]
    if progress.phase == "accepted":
        word = f"accepted, {progress.seconds:.0f} s"
    elif progress.phase == "dwell":
        done = round(20 * progress.seconds / progress.wanted)
        word = f"{word} {'#' * done}{'.' * (20 - done)} {progress.seconds:.0f} of {progress.wanted:.0f} s"
    elif progress.phase == "turn":
        word = f"{word} {progress.seconds:.0f} s"
    return f"{word}: {progress.note}" if progress.note else word
