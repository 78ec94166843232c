"""The one thing that all tabs are to see, and the web server before it."""

import os
import select
import socket
import socketserver
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from queue import Queue
from threading import Lock, Thread
from typing import Self

from tests.patience import HANG_S

SERVE = """
import sys
from station.tui.web import serve
serve(sys.argv[1:], lambda url: print(url, flush=True), port=0)
"""
SERVE_REPORT = """
import sys
from pathlib import Path
from station.tui.web import serve
report = Path(sys.argv[1])
found = lambda: report if report.parent.exists() else None
serve(["true"], lambda url: print(url, flush=True), port=0, report=found)
"""


class Engine(socketserver.ThreadingUnixStreamServer):
    """Hears the keys of every screen and says a colour to all of them, also to those that come later."""

    daemon_threads = True

    def __init__(self, path: Path) -> None:
        self.heard = Queue[tuple[int, str]]()  # process, key: the number itself first
        self._screens = set[_Screen]()
        self._colour, self._lock = "#102030", Lock()
        super().__init__(str(path), _Screen)

    def __enter__(self) -> Self:
        Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
        self.server_close()

    def say(self, colour: str) -> None:
        with self._lock:
            self._colour = colour
            for screen in self._screens:
                screen.say(colour)

    def hang_up(self) -> None:
        with self._lock:
            for screen in self._screens:
                screen.connection.shutdown(socket.SHUT_RDWR)

    def next(self) -> tuple[int, str]:
        return self.heard.get(timeout=HANG_S)

    def new_screen(self) -> int:
        process, reported = self.next()
        assert reported == str(process)
        return process

    def join(self, screen: "_Screen") -> None:
        with self._lock:
            self._screens.add(screen)
            screen.say(self._colour)

    def leave(self, screen: "_Screen") -> None:
        with self._lock:
            self._screens.discard(screen)


class _Screen(socketserver.StreamRequestHandler):
    server: Engine

    def handle(self) -> None:
        process = 0
        for line in self.rfile:
            reported = line.decode().strip()
            if not process:
                process = int(reported)
                self.server.join(self)
            self.server.heard.put((process, reported))

    def finish(self) -> None:
        self.server.leave(self)
        super().finish()

    def say(self, colour: str) -> None:
        self.wfile.write(colour.encode() + b"\n")


class WebServer:
    """``serve`` in a process of its own; ``url`` is the page's."""

    def __init__(self, command: Sequence[str]) -> None:
        self._command = [sys.executable, "-P", "-c", SERVE, *command]

    def __enter__(self) -> Self:
        self.process = subprocess.Popen(self._command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.url = self.process.stdout.readline().strip()
        assert self.url.startswith("http://127.0.0.1:"), self.process.communicate()
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(HANG_S)
        for stream in (self.process.stdout, self.process.stderr):
            assert stream is not None
            stream.close()

    def reported(self) -> tuple[str, str]:
        """Wait for its end and return what it still said, on stdout and stderr."""
        return self.process.communicate(timeout=HANG_S)


def has_ended(process: int) -> bool:
    """Wait until a process is over, which may be nobody's child here."""
    try:
        handle = os.pidfd_open(process)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([handle], [], [], HANG_S)[0])
    finally:
        os.close(handle)
