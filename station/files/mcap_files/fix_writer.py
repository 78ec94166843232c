"""A GNSS receiver's fixes and times as MCAP, beside the IMU's file; readable after a kill."""

import os
from dataclasses import fields
from pathlib import Path

from fixtures_db.folder_on_disk import sync_folder
from procedures.earth.gnss_records import AirData, GnssFix, TimeMark
from station.errors import cannot_write
from station.files.flush_pace import FlushPace
from station.files.mcap_files.fix_schemas import FIX_MESSAGES, FIX_SCHEMA, TOPICS
from station.files.mcap_files.new_file import new_channel, new_file

FLUSH_PERIOD_S = 0.5
GAP = "station.gap"


class FixWriter:
    """Writes records as they come; a file is never overwritten."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.fixes, self._is_named = 0, False  # its name is on the disk
        self._stream, self._writer = new_file(path)
        self._channels = {
            kind: new_channel(self._writer, topic, f"station.{kind.__name__}", FIX_SCHEMA)
            for kind, topic in TOPICS.items()
        }
        self._pace = FlushPace(FLUSH_PERIOD_S)

    def write(self, record: GnssFix | TimeMark | AirData) -> None:
        """Write one; raise `CannotWrite` if the disk refuses."""
        known = {f.name: value for f in fields(record) if (value := getattr(record, f.name)) is not None}
        content = FIX_MESSAGES[type(record)](**known).SerializeToString()
        self.fixes += isinstance(record, GnssFix)
        try:
            channel, host_ns = self._channels[type(record)], record.host_ns
            self._writer.add_message(channel, log_time=host_ns, data=content, publish_time=host_ns)
            if self._pace.is_due:
                self._flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def mark(self, host_ns: int, reason: str, *, is_open: bool) -> None:
        """Write that something may be missing from here on, as a metadata record; raise `CannotWrite`."""
        try:
            self._writer.add_metadata(
                GAP, {"host_ns": str(host_ns), "reason": reason, "is_open": str(is_open).lower()}
            )
            self._flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def close(self) -> None:
        """Finish the file on the disk; a second call changes nothing."""
        if self._stream.closed:
            return
        try:
            self._flush()  # the data before the end: a file that has its end has all of them
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error
        finally:
            self._stream.close()

    def _flush(self) -> None:
        with self._pace.flushing():
            self._writer.flush()  # type: ignore[no-untyped-call]
            os.fsync(self._stream.fileno())
            if not self._is_named:
                sync_folder(self.path.parent)
                self._is_named = True
