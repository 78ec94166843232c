"""The engine's end of the Unix socket: views out to every screen, commands in, a line of JSON each.

The socket stands in a folder of its own that only its user may enter.
"""

import contextlib
import socketserver
import threading
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Self

from pydantic import ValidationError

from station.guide.command import OperatorCommand
from station.guide.view import CalibrationView

MIN_VIEW_INTERVAL_S = 0.05  # between two views to one screen
LONGEST_LINE = 65536


class ViewServer(socketserver.ThreadingUnixStreamServer):
    """Serves views at ``path`` while the ``with`` block lasts."""

    daemon_threads = True
    block_on_close = False

    def __init__(self, path: Path) -> None:
        self._commands: SimpleQueue[OperatorCommand] = SimpleQueue()
        self._changed = threading.Condition()
        self._version, self.is_closed = 0, False
        self._view: CalibrationView | None = None
        super().__init__(str(path), _Screen)

    def __enter__(self) -> Self:
        threading.Thread(target=self.serve_forever, args=(0.1,), name="screens", daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        with self._changed:
            self.is_closed = True
            self._changed.notify_all()
        self.shutdown()
        self.server_close()

    def publish(self, view: CalibrationView) -> None:
        """Show a view to every screen; returns at once."""
        if view == self._view:
            return
        with self._changed:
            self._view, self._version = view, self._version + 1
            self._changed.notify_all()

    @property
    def view(self) -> CalibrationView | None:
        """What was published last."""
        return self._view

    def commands(self, timeout_s: float) -> list[OperatorCommand]:
        """Return what was asked since the last call; wait at most ``timeout_s`` for the first of it."""
        found = list[OperatorCommand]()
        with contextlib.suppress(Empty):
            found.append(self._commands.get(timeout=timeout_s) if timeout_s else self._commands.get_nowait())
            while True:
                found.append(self._commands.get_nowait())
        return found

    def next_text(self, seen: int) -> tuple[int, bytes]:
        """Wait for a view newer than version ``seen``; empty once the server is closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._version > seen or self.is_closed)
            version, view = self._version, self._view
        # written here, as most views are never sent
        return version, b"" if self.is_closed or view is None else view.model_dump_json().encode() + b"\n"

    def put(self, line: bytes) -> None:
        """Take a line from a screen; one that is no command is dropped."""
        with contextlib.suppress(ValidationError):
            self._commands.put(OperatorCommand.model_validate_json(line))


class _Screen(socketserver.StreamRequestHandler):
    server: ViewServer

    def handle(self) -> None:
        version, left = 0, threading.Event()
        threading.Thread(target=self._listen, args=(left,), daemon=True).start()
        with contextlib.suppress(OSError):
            while not (left.wait(MIN_VIEW_INTERVAL_S) or self.server.is_closed):
                version, text = self.server.next_text(version)
                self.wfile.write(text)

    def _listen(self, left: threading.Event) -> None:
        with contextlib.suppress(OSError, ValueError):
            while line := self.rfile.readline(LONGEST_LINE):
                self.server.put(line)
        left.set()
