"""The session's raw recording: every byte as read, in MCAP, on its own thread so that a slow disk stalls no read.

Chunks are closed every 0.2 s and on the disk every 0.5 s. Gaps and the session's start stand in it
as metadata records ``station.gap`` and ``station.session``.
"""

import threading
import time
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue

from station.errors import CannotWrite, cannot_write
from station.files.atomic_file import FlushInterval
from station.files.mcap_files.schemas import MESSAGES, RAW, SCHEMA
from station.files.mcap_files.writer import GrowingFile, new_channel
from station.stream.reader.messages import Chunk, Item, StreamGap

FLUSH_S = 0.2
SYNC_S = 0.5
SESSION = "station.session"


class RawRecording(GrowingFile):
    """Writes what it is given, in order; ``on_failure`` is called once, on its thread, if it no longer can."""

    def __init__(
        self, path: Path, session: dict[str, str], on_failure: Callable[[CannotWrite], None], topic: str
    ) -> None:
        super().__init__(path)
        self._on_failure = on_failure
        self._items: SimpleQueue[Item | None] = SimpleQueue()
        try:
            self._writer.add_metadata(SESSION, session)
            self._raw = new_channel(self._writer, topic, RAW, SCHEMA)
            self.flush()
        except OSError as error:
            self.let_go()
            raise cannot_write(path, error) from error
        self._thread = threading.Thread(target=self._run, name="recording", daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Take a chunk or a gap mark; returns at once."""
        self._items.put(item)

    def close(self) -> None:
        """Write what was taken and finish the file."""
        self._items.put(None)
        self._thread.join()

    def _run(self) -> None:
        try:
            self._write_all()
            self.finish()
        except OSError as error:
            self.let_go()
            self._on_failure(cannot_write(self.path, error))

    def _write_all(self) -> None:
        pace, synced = FlushInterval(FLUSH_S), time.monotonic()
        while True:
            try:
                item = self._items.get(timeout=FLUSH_S)
                if item is None:
                    return
                self._write(item)
            except Empty:
                pass
            if pace.is_due:
                now = time.monotonic()
                sync = now - synced >= SYNC_S
                with pace.flushing():
                    self.flush(sync=sync)
                synced = now if sync else synced

    def _write(self, item: Item) -> None:
        match item:
            case Chunk(host_ns, data):
                self.add(self._raw, host_ns, MESSAGES[RAW](data=data, host_ns=host_ns).SerializeToString())
            case StreamGap(host_ns, reason, is_open):
                self.add_gap(host_ns, reason, is_open=is_open)
