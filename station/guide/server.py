"""The engine as a process: ``python -m station.guide.server SOCKET``, options as JSON on stdin until it closes.

Views go out to every screen, commands come in, a line of JSON each. The socket is in a folder that only its user
may enter. A round that takes long, mostly because of a slow disk, is reported meanwhile by a `StallNotice`.
"""

import contextlib
import os
import socketserver
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Self

from pydantic import ValidationError

from fixtures_db.database import Database, open_db
from fixtures_db.errors import DatabaseError
from station.errors import exit_code
from station.guide.engine import CalibrationEngine
from station.guide.options import EngineOptions
from station.guide.view import ENDED_STAGES, VERDICT_STAGES, CalibrationView, OperatorCommand

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
        self.view: CalibrationView | None = None  # what was published last
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
        if view == self.view:
            return
        with self._changed:
            self.view, self._version = view, self._version + 1
            self._changed.notify_all()

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
            version, view = self._version, self.view
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


STALL_S = 3.0  # a round of the engine takes 0.1 s, accepting a step 0.3 s
LOOK_S = 0.5
SELF_EXPLAINED_STAGES = frozenset({"start", "connecting", "solving"}) | ENDED_STAGES | VERDICT_STAGES
STALL_HINT = "writing to the disk for {seconds:.0f} s, which is slow: do nothing; all accepted steps are safe"


class StallNotice:
    """Publishes ``shown``'s view with a hint while a round lasts; use it in a ``with``."""

    def __init__(
        self, shown: Callable[[], CalibrationView | None], publish: Callable[[CalibrationView], None]
    ) -> None:
        self._shown, self._publish = shown, publish
        self._since: float | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="held up", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    @contextmanager
    def round(self) -> Iterator[None]:
        """Watch over one round."""
        self._since = time.monotonic()
        try:
            yield
        finally:
            self._since = None

    def _run(self) -> None:
        while not self._stop.wait(LOOK_S):
            since, view = self._since, self._shown()
            if since is None or view is None or view.stage in SELF_EXPLAINED_STAGES:
                continue
            if (seconds := time.monotonic() - since) >= STALL_S:
                self._publish(view.model_copy(update={"hint": STALL_HINT.format(seconds=seconds)}))


IDLE_S = 0.1
DRAWN_S = 1.0  # what a screen may take to draw its first view before anything else asks for the processor


def serve(path: Path, options: EngineOptions) -> None:
    """Serve one engine until stdin is closed; a database that cannot be opened is a view that says so."""
    stop = threading.Event()
    threading.Thread(target=_watch_stdin, args=(stop,), daemon=True).start()
    with ViewServer(path) as server:
        try:
            database = open_db(options.database)
        except DatabaseError as error:
            server.publish(CalibrationView(stage="failed", error=str(error), code=exit_code(error) or 0))
            stop.wait()
            return
        with database:
            _serve(server, database, options, stop)


def _serve(server: ViewServer, database: Database, options: EngineOptions, stop: threading.Event) -> None:
    engine = CalibrationEngine(database, options.engine(), server.publish)
    operator = None
    if options.first is None:
        server.publish(engine.view)
        threading.Thread(target=_prefetch, args=(stop,), daemon=True).start()
    with StallNotice(lambda: server.view, server.publish) as watch, closing(engine):
        if options.first is not None:
            engine.execute(options.first)
        while not stop.is_set():
            for command in server.commands(0.0 if engine.is_busy else IDLE_S):
                engine.execute(command)
            with watch.round():
                engine.round()
            server.publish(engine.view)
            if engine.is_busy and (operator := operator or options.operator()):
                engine.move_cube_by(operator)


def _prefetch(stop: threading.Event) -> None:
    """Import what a campaign needs, while nobody waits for it."""
    if not stop.wait(DRAWN_S):
        import station.guide.campaign.port_check  # noqa: F401


def _watch_stdin(stop: threading.Event) -> None:
    while os.read(0, 4096):
        pass
    stop.set()


if __name__ == "__main__":
    serve(Path(sys.argv[1]), EngineOptions.model_validate_json(sys.stdin.readline()))
