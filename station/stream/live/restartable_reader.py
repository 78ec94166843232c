"""A reader process that is begun again, in the same folder, when it has ended."""

import contextlib
import time
from pathlib import Path

from drivers.errors import DriverError
from station.files.new_folder import journal_path
from station.stream.live.live_feed import LiveFeed
from station.stream.reader import Reader

RETRY_S = 1.0  # between two tries to read a port whose reader died


class RestartableReader:
    """Reads ``url`` into journals of ``folder``; `restart` has the reader of ``feed`` begin again."""

    def __init__(self, url: str, folder: Path) -> None:
        self._url, self._folder = url, folder
        self.reader = Reader(url, journal_path(folder))
        self.reader.start()
        self.feed: LiveFeed | None = None
        self._retry_at = 0.0

    def restart(self) -> None:
        """Begin it again, if it has ended and a second has passed."""
        if self.feed is None or self.reader.ended is None or time.monotonic() < self._retry_at:
            return
        self._retry_at = time.monotonic() + RETRY_S
        self.reader.close()
        self.reader = Reader(self._url, journal_path(self._folder))
        with contextlib.suppress(DriverError):  # tried again and again
            self.reader.start()
            self.feed.replace_source(self.reader)

    def close(self) -> None:
        """End the reader."""
        self.reader.close()
