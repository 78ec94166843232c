"""Recordings as live devices: an IMU's bytes and a receiver's records come again as they came then.

A receiver's files stand next to the IMU's.
"""

import csv
import time
from itertools import chain
from pathlib import Path

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import PortNotFound, ReplayEnded
from procedures.gnss_records import GnssFix
from station.errors import DataRefused
from station.files.mcap_files import read_step
from station.files.mcap_files.gnss_file import Record, read_fixes
from station.stream.auxiliary import RecordedCompanion, read_late_messages
from station.stream.reader import Chunk, StreamGap
from station.stream.stream_events import EVENTS_FILE


def recorded_gnss(file: Path) -> RecordedCompanion[Record] | None:
    """Return the receiver recorded alongside an IMU's file; None where there was none."""
    records = read_recorded_fixes(file)
    late = read_late_messages(file.parent, "gnss")
    return RecordedCompanion("GNSS", iter(records), late, _is_fix) if records else None


def _is_fix(record: Record) -> bool:
    return isinstance(record, GnssFix) and not record.is_filtered


def read_recorded_fixes(file: Path) -> list[Record]:
    """Return what receivers recorded alongside an IMU's file reported, in order of reading."""
    found = [path for path in sorted(file.parent.glob("gnss_*.mcap")) if not path.name.startswith("gnss_session_")]
    return sorted(chain.from_iterable(map(read_fixes, found)), key=lambda record: record.host_ns)


def recorded_choice(file: Path, event: str) -> str:
    """Return what a recording was monitored with, "aid" or "laws", empty where its folder does not say.

    Raise `DataRefused` if the folder's table of events cannot be read.
    """
    path = file.parent / EVENTS_FILE
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            return next((row.get("text") or "" for row in csv.DictReader(stream) if row.get("event") == event), "")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataRefused(path, None, f"no readable table ({error})", f"the {EVENTS_FILE} of a run") from error


MAGIC = b"\x89MCAP0"


def is_mcap(path: Path) -> bool:
    """Return whether a file begins as MCAP does; one that cannot be read does not."""
    try:
        with path.open("rb") as stream:
            return stream.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


class Replay:
    """Gives out a file's chunks ``speed`` times as fast as they came; 0: as fast as they are taken.

    Raises
    ------
    PortNotFound, DataRefused
        If the file holds no bytes of a device, or is damaged.
    """

    def __init__(self, url: str, speed: float = 1.0) -> None:
        self.address: DeviceAddress = parse_device_url(url)
        self._speed = speed
        self._chunks = [Chunk(host_ns, data) for host_ns, data in read_step(Path(self.address.name)).raw]
        if not self._chunks:
            raise PortNotFound(self.address.name, "holds no bytes of a device", "name a session or a recording")
        self._size = sum(len(chunk.data) for chunk in self._chunks)
        self._at, self._began = 0, time.monotonic()

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return the chunks that are due, waiting at most ``timeout_s``; raise `ReplayEnded` after the last."""
        if self._at == len(self._chunks):
            raise ReplayEnded(self.address.name, self._size)
        if not self._speed:
            self._at += 1
            return [self._chunks[self._at - 1]]
        wait = self._due(self._at) - time.monotonic()
        if wait > 0:
            time.sleep(min(wait, timeout_s))
        found = list[Chunk | StreamGap]()
        while self._at < len(self._chunks) and self._due(self._at) <= time.monotonic():
            found.append(self._chunks[self._at])
            self._at += 1
        return found

    def _due(self, index: int) -> float:
        return self._began + (self._chunks[index].host_ns - self._chunks[0].host_ns) / 1e9 / self._speed
