"""Samples as lines of JSON, ``stream/1``, on stdout; a reader that is slow holds up nobody but itself."""

import json
import math
import os
import select
import sys
import threading
from collections import deque

import numpy as np

from station.errors import CannotWrite, cannot_write
from station.files.mcap_files.schemas import COLUMNS
from station.sending.outputs import About, BadAddress, CalibratedSamples, names
from station.text import plural

FORMAT = "stream/1"
MAX_WAITING = 20000  # samples: ten seconds of 2 kHz
FAREWELL_S = 2.0


def lines(samples: CalibratedSamples) -> list[str]:
    """Return a line of JSON for each sample; what is not known is omitted."""
    six = np.hstack((samples.f, samples.omega)).tolist()
    rows = zip(
        samples.sequence.tolist(), samples.t.tolist(), samples.utc.tolist(), six, samples.temperature.tolist(),
        samples.flags.tolist(), samples.lost.tolist(), strict=True,
    )  # fmt: skip
    found = list[str]()
    for sequence, t, utc, values, temperature, flags, lost in rows:
        row = {"format": FORMAT, "sequence": sequence, "t_s": t}
        if math.isfinite(utc):
            row["utc_s"] = utc
        row |= {name: value for name, value in zip(COLUMNS, values, strict=True) if math.isfinite(value)}
        if math.isfinite(temperature):
            row["temperature_c"] = temperature
        row["flags"] = names(flags)
        if lost:
            row["lost"] = lost
        found.append(json.dumps(row))
    return found


class StdoutLines:
    """Writes on a thread of its own, from a queue that has an end."""

    name = "stdout"

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._waiting: deque[tuple[int, bytes]] = deque()  # samples, their lines
        self._samples, self._dropped, self._is_over, self._is_closing = 0, 0, False, False
        self._refused: CannotWrite | None = None
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="stdout", daemon=True)
        self._thread.start()

    @property
    def dropped(self) -> int:
        """The samples that found no room."""
        return self._dropped

    @property
    def is_over(self) -> bool:
        """Whether the reader has left."""
        return self._is_over

    def send(self, samples: CalibratedSamples) -> None:
        """Put samples into the queue, or drop them where it is full.

        Raises
        ------
        CannotWrite
            Once, if what stdout leads to refused what was written before, as a full disk does.
        """
        self._raise_refusal()
        n = len(samples)
        if self._is_over or self._samples + n > MAX_WAITING:
            self._dropped += n
            return
        text = ("\n".join(lines(samples)) + "\n").encode()
        with self._changed:
            self._waiting.append((n, text))
            self._samples += n
            self._changed.notify()

    def status(self) -> str:
        """Return what was dropped, and whether somebody reads."""
        if self._is_over:
            return "stdout: its reader has left"
        return f"stdout: {plural(self._dropped, 'sample')} dropped"

    def close(self) -> None:
        """Write what waits, for two seconds at most; raise as `send`."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        self._thread.join(FAREWELL_S)
        self._dropped += self._samples
        self._raise_refusal()

    def _raise_refusal(self) -> None:
        refused, self._refused = self._refused, None
        if refused is not None:
            raise refused

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._waiting or self._is_closing)
                if not self._waiting:
                    return
                n, text = self._waiting.popleft()
            try:
                self._write(text)
            except BrokenPipeError:
                self._is_over = True
                return
            except OSError as error:
                self._refused = cannot_write("stdout", error)
                return
            with self._changed:
                self._samples -= n

    def _write(self, text: bytes) -> None:
        while text:
            try:
                text = text[os.write(self._descriptor, text) :]
            except BlockingIOError:  # a pipe that somebody set to not wait: full
                select.select([], [self._descriptor], [])


def open_output(where: str, about: About) -> StdoutLines:
    """Return the output on stdout.

    Raise `BadAddress` if more than ``stdout`` was reported.
    """
    if where:
        raise BadAddress(f"stdout:{where}", repr(where), "stdout alone")
    sys.stdout.flush()
    return StdoutLines(sys.stdout.fileno())
