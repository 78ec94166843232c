"""The session's raw recording: every byte as read, in MCAP, on its own thread so that a slow disk stalls no read.

Chunks are closed every 0.2 s and on the disk every 0.5 s. Gaps and the session's start stand in it
as metadata records ``station.gap`` and ``station.session``.
"""

import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue

from fixtures_db.folder_on_disk import sync_folder
from station.errors import CannotWrite, cannot_write
from station.files.atomic_file import FlushInterval
from station.files.mcap_files.schemas import MESSAGES, RAW, SCHEMA
from station.files.mcap_files.writer import new_channel, new_file
from station.stream.reader.messages import Chunk, Item, StreamGap

FLUSH_S = 0.2
SYNC_S = 0.5
SESSION, GAP = "station.session", "station.gap"


class RawRecording:
    """Writes what it is given, in order; ``on_failure`` is called once, on its thread, if it no longer can."""

    def __init__(
        self, path: Path, session: dict[str, str], on_failure: Callable[[CannotWrite], None], topic: str,
    ) -> None:  # fmt: skip
        self.path = path
        self._on_failure = on_failure
        self._items: SimpleQueue[Item | None] = SimpleQueue()
        self._stream, self._writer = new_file(path)
        try:
            self._writer.add_metadata(SESSION, session)
            self._raw = new_channel(self._writer, topic, RAW, SCHEMA)
            self._flush(sync=True)
            sync_folder(path.parent)
        except OSError as error:
            self._leave()
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
            self._flush(sync=True)  # the data before the end: a file that has its end has all of them
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._flush(sync=True)
            self._stream.close()
        except OSError as error:
            self._leave()
            self._on_failure(cannot_write(self.path, error))

    def _leave(self) -> None:
        """Close the file; what is left to write is tried once more, and lost where the disk still refuses."""
        with suppress(OSError):
            self._stream.close()

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
                    self._flush(sync=sync)
                synced = now if sync else synced

    def _write(self, item: Item) -> None:
        match item:
            case Chunk(host_ns, data):
                content = MESSAGES[RAW](data=data, host_ns=host_ns).SerializeToString()
                self._writer.add_message(self._raw, log_time=host_ns, data=content, publish_time=host_ns)
            case StreamGap(host_ns, reason, is_open):
                metadata = {"host_ns": str(host_ns), "reason": reason, "is_open": str(is_open).lower()}
                self._writer.add_metadata(GAP, metadata)

    def _flush(self, *, sync: bool) -> None:
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._stream.flush()
        if sync:
            os.fsync(self._stream.fileno())
