"""A reader that lasts: where its process dies another one is started, aside, and the station goes on meanwhile."""

import time
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from threading import Event

from drivers.errors import DriverError
from station.files.new_folder import journal_path
from station.stream.reader import Chunk, GapMark, Reader

RETRY_S = 0.5  # between two tries
FOR_EVER = 2**63 - 1  # ns: the moment up to which nothing more comes of what is gone


class RestartingReader:
    """Reads ``url`` by one process after another, each with its own journal in ``folder``; use it in a ``with``.

    The journals are ``NAME_*.mcap``, of the session's ``name``; without a folder there are none.

    The death of a process and the beginning of the next are gap marks.
    """

    def __init__(self, url: str, folder: Path | None, name: str = "gnss_session") -> None:
        self._url, self._folder, self._name = url, folder, name
        self._closing = Event()
        self._aside = ThreadPoolExecutor(1, "reader")
        self._next: Future[Reader] | None = None
        self.reader = self._new_reader()
        self.address = self.reader.address

    def __enter__(self) -> "RestartingReader":
        self.reader.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._closing.set()
        self._aside.shutdown()
        if self._next is not None and self._next.exception() is None:
            self._next.result().close()
        self.reader.close()

    @property
    def up_to_ns(self) -> int:
        """The moment up to which all that came was polled [ns]."""
        return self.reader.up_to_ns

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        """Return what has come, within ``timeout_s``; raise `CannotWrite` if the disk refuses a journal."""
        if self._next is not None:
            return self._taken_up(self._next, timeout_s)
        try:
            return self.reader.poll(timeout_s)
        except DriverError as error:
            self.reader.close()
            self._next = self._aside.submit(self._another, 0.0)
            return [GapMark(time.time_ns(), getattr(error, "reason", str(error)), False)]

    def _taken_up(self, coming: Future[Reader], timeout_s: float) -> list[Chunk | GapMark]:
        if wait([coming], timeout_s).not_done:
            return []
        try:
            self.reader, self._next = coming.result(), None
        except DriverError:  # such as a port that is busy, or gone as well
            self._next = self._aside.submit(self._another, RETRY_S)
            return []
        return [GapMark(time.time_ns(), "another reader process has begun", True)]

    def _another(self, after_s: float) -> Reader:
        self._closing.wait(after_s)
        reader = self._new_reader()
        reader.start()
        return reader

    def _new_reader(self) -> Reader:
        return Reader(self._url, None if self._folder is None else journal_path(self._folder, self._name))
