"""The station's end of a reader process; where that dies, `RestartingReader` starts another."""

import math
import os
import select
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from threading import Event

from drivers.address_parsing import parse_device_url
from drivers.errors import DriverError, LinkLost, ReplayEnded
from station.errors import CannotWrite
from station.files.atomic_file import recording_path
from station.stream.reader.messages import Chunk, Item, Quiet, Refusal, StreamGap, unpacked

START_TIMEOUT_S = 90.0  # imports on a busy machine, 5 s to connect, a recording on a disk that takes 5 s a write
STOP_TIMEOUT_S = 10.0
WRITES_WITHIN_S = 30.0  # a recording that is being finished on a slow disk has grown by then
_PIPE_BYTES = 2**20


class Reader:
    """A device being read and recorded by a process of its own; use it in a ``with``.

    Parameters
    ----------
    url : str
        The device's address, see `drivers.addresses`.
    recording : Path
        Where the session's raw bytes go; it must not be there yet. None: they are not kept.
    """

    def __init__(self, url: str, recording: Path | None) -> None:
        self.address = parse_device_url(url)
        self.recording = recording
        self._buffer = bytearray()
        self._items: list[Item] = []
        self.ended: DriverError | CannotWrite | None = None  # why nothing more will come
        self.up_to_ns = 0  # all that came until then has been returned, or will be by the next `poll`

    def __enter__(self) -> "Reader":
        self.start()
        return self

    def start(self) -> None:
        """Start the process and wait until the port is open; raise what it met, such as `PortBusy`."""
        command = [sys.executable, "-P", "-m", "station.stream.reader", self.address.text]
        command += [] if self.recording is None else [str(self.recording)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0,
            start_new_session=True,  # Ctrl-C is for the station, which then closes stdin
        )  # fmt: skip
        try:
            waits = math.inf if self.address.scheme == "replay" else START_TIMEOUT_S  # a long log is read first
            deadline = time.monotonic() + waits
            while not self.up_to_ns:  # the first message says that the port is open
                self._collect(min(max(0.0, deadline - time.monotonic()), START_TIMEOUT_S))
                if self.ended is not None and not isinstance(self.ended, ReplayEnded):  # that is for `poll`
                    raise self.ended
                if time.monotonic() > deadline:
                    raise LinkLost(self.address.name, "the reader process did not start")
        except BaseException:
            self.close()
            raise

    def __exit__(self, *raised: object) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def poll(self, timeout_s: float) -> list[Item]:
        """Return what has come since the last call; wait at most ``timeout_s`` for the first of it.

        Raises
        ------
        ReplayEnded, LinkLost, CannotWrite
            Once everything before it was returned: at a replay's end, if the reader process died, if the
            recording could not be written.
        """
        if not self._items:
            if self.ended is not None:
                raise self.ended
            self._collect(timeout_s)
        items, self._items = self._items, []
        if not items and self.ended is not None:
            raise self.ended
        return items

    def close(self) -> None:
        """Have the recording finished and the process ended; may be called twice."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        if self._process.stdout is not None:
            self._process.stdout.close()
        timeout_s, size = STOP_TIMEOUT_S if self.recording is None else WRITES_WITHIN_S, -1
        while True:
            try:
                self._process.wait(timeout_s)
                return
            except subprocess.TimeoutExpired:
                size, before = self._recording_size(), size
                if size <= before:
                    self._process.kill()
                    self._process.wait()
                    return

    def _recording_size(self) -> int:
        return self.recording.stat().st_size if self.recording is not None and self.recording.exists() else -1

    def _collect(self, timeout_s: float) -> None:
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], [], [], timeout_s)
        if not ready:
            return
        data = os.read(self._process.stdout.fileno(), _PIPE_BYTES)
        if not data:
            code = self._process.wait()
            self.ended = LinkLost(self.address.name, f"the reader process ended, exit code {code}")
        self._buffer += data
        for message in unpacked(self._buffer):
            if isinstance(message, Refusal):
                self.ended = message.error
                continue
            self.up_to_ns = max(self.up_to_ns, message.host_ns)
            if not isinstance(message, Quiet):
                self._items.append(message)


RETRY_S = 0.5  # between two tries
FOR_EVER = 2**63 - 1  # ns: the moment up to which nothing more comes of what is gone


class RestartingReader:
    """Reads ``url`` by one process after another, each with its own recording in ``folder``; use it in a ``with``.

    The recordings are ``NAME_*.mcap``, of the session's ``name``; without a folder there are none.

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

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come, within ``timeout_s``; raise `CannotWrite` if the disk refuses a recording."""
        if self._next is not None:
            return self._taken_up(self._next, timeout_s)
        try:
            return self.reader.poll(timeout_s)
        except DriverError as error:
            self.reader.close()
            self._next = self._aside.submit(self._another, 0.0)
            return [StreamGap(time.time_ns(), getattr(error, "reason", str(error)), False)]

    def _taken_up(self, coming: Future[Reader], timeout_s: float) -> list[Chunk | StreamGap]:
        if wait([coming], timeout_s).not_done:
            return []
        try:
            self.reader, self._next = coming.result(), None
        except DriverError:  # such as a port that is busy, or gone as well
            self._next = self._aside.submit(self._another, RETRY_S)
            return []
        return [StreamGap(time.time_ns(), "another reader process has begun", True)]

    def _another(self, after_s: float) -> Reader:
        self._closing.wait(after_s)
        reader = self._new_reader()
        reader.start()
        return reader

    def _new_reader(self) -> Reader:
        return Reader(self._url, None if self._folder is None else recording_path(self._folder, self._name))
