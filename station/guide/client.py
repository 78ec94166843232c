"""Starts the engine's process and connects a screen to its Unix socket; the process ends with its starter."""

import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

from procedures.errors import ErrorCode
from station.errors import StationError
from station.guide.options import EngineOptions
from station.guide.view import ENDED_STAGES, CalibrationView, OperatorCommand

START_S = 30.0
ENDED = "the recording program has stopped; all accepted steps are safe: continue with `station resume`"


class EngineConnection:
    """The engine at ``path``, as a `CalibrationSession`.

    ``view`` is its newest; ``changed`` is called on each new one, on a thread of its own.
    """

    def __init__(self, path: Path, changed: Callable[[], None] = lambda: None) -> None:
        self._socket = _connected(path)
        self.changed = changed
        self.view = CalibrationView(stage="connecting", line="starting")
        self._sending = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="views", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def send(self, command: OperatorCommand) -> None:
        """Ask something of the engine; nothing happens if it has ended."""
        line = command.model_dump_json(exclude_defaults=True).encode() + b"\n"
        try:
            with self._sending:
                self._socket.sendall(line)
        except OSError:
            self._has_ended()

    def close(self) -> None:
        """Hang up; the engine goes on."""
        with suppress(OSError):  # it has hung up already
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()

    def _run(self) -> None:
        with suppress(OSError), self._socket.makefile("rb") as stream:  # an error is as its end
            for line in stream:
                self.view = CalibrationView.model_validate_json(line)
                self.changed()
        self._has_ended()

    def _has_ended(self) -> None:
        if self.view.stage not in ENDED_STAGES:
            self.view = self.view.model_copy(update={"stage": "failed", "error": ENDED})
            self.changed()


def _connected(path: Path) -> socket.socket:
    deadline = time.monotonic() + START_S
    while True:
        try:
            found = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            found.connect(str(path))
            return found
        except OSError:
            found.close()
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)


END_S = 30.0  # a solve under way, and a reader's farewell


class EngineFailed(StationError):
    """The engine's process ended as it should not: a bug."""

    code = ErrorCode.BUG

    def __init__(self, exit_code: int, stderr: str) -> None:
        self.exit_code, self.stderr = exit_code, stderr
        last = stderr.strip().splitlines()[-1:] or [f"exit code {exit_code}"]
        super().__init__(
            f"the recording program has stopped: {last[0]}; all accepted steps are safe, see `station resume`. "
            "Report this bug"
        )


@contextmanager
def engine_process(options: EngineOptions) -> Iterator[Path]:
    """Yield the path of the socket of an engine that lives as long as the ``with`` lasts."""
    with tempfile.TemporaryDirectory(prefix="station-") as folder:  # mode 0700
        socket, log = Path(folder) / "engine", Path(folder) / "stderr"
        with log.open("w") as errors, subprocess.Popen(
            [sys.executable, "-P", "-m", "station.guide.server", str(socket)],
            stdin=subprocess.PIPE, stderr=errors, text=True,  # a screen has the terminal to itself
            start_new_session=True,  # Ctrl-C is for the screen
        ) as process:  # fmt: skip
            assert process.stdin is not None
            try:
                process.stdin.write(options.model_dump_json() + "\n")
                process.stdin.flush()
                yield socket
            finally:
                process.stdin.close()
                try:
                    process.wait(END_S)
                except subprocess.TimeoutExpired:
                    process.kill()  # it waits for something of its own; what was accepted is on the disk
                if process.returncode:  # None where it was killed
                    raise EngineFailed(process.returncode, log.read_text())
