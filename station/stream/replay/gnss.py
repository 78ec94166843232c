"""The receiver of a recording that is replayed: its files stand beside the IMU's.

What it said is given out by the moments at which it was read then, as the IMU's bytes are.
"""

import csv
from collections import deque
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from procedures.earth.gnss_records import GnssFix
from station.errors import DataRefused
from station.files.mcap_files.fix_reader import Record, read_fixes
from station.stream.reader.restarting_reader import FOR_EVER
from station.stream.stream_events import EVENTS_FILE, StreamState

RATE_NS = 5 * 10**9


class RecordedGnss:
    """`station.monitor.monitor.Aid` of records in the order in which they came."""

    up_to_ns = FOR_EVER

    def __init__(self, records: Sequence[Record]) -> None:
        self._records = deque(records)
        self._fixes, self._seen, self._now = 0, deque[int](), 0

    def advance(self) -> None:
        """Nothing more will come."""

    def take(self, until_ns: int) -> Sequence[Record]:
        """Return what came since the last call and until a moment [ns], in order."""
        found = list[Record]()
        while self._records and self._records[0].host_ns <= until_ns:
            found.append(self._records.popleft())
        self._look(found, until_ns)
        return found

    def utc(self, host_ns: int) -> float | None:
        """Return UTC where it is known: a replay writes no reference time anew."""
        return None

    def stream(self) -> StreamState:
        """Return how often fixes came then, and how old the newest was."""
        age = (self._now - self._seen[-1]) / 1e9 if self._seen else 0.0
        rate = sum(at > self._now - RATE_NS for at in self._seen) / (RATE_NS / 1e9)
        return StreamState("GNSS recorded", rate, age, self._fixes, gaps=0, lost=0, bad=0)

    def _look(self, found: Sequence[Record], until_ns: int) -> None:
        self._now = until_ns
        came = [record.host_ns for record in found if isinstance(record, GnssFix) and not record.is_filtered]
        self._fixes += len(came)
        self._seen.extend(came)
        while len(self._seen) > 1 and self._seen[0] <= until_ns - RATE_NS:
            self._seen.popleft()


def recorded_gnss(file: Path) -> RecordedGnss | None:
    """Return the receiver recorded beside an IMU's file; None where there was none."""
    records = read_recorded_fixes(file)
    return RecordedGnss(records) if records else None


def read_recorded_fixes(file: Path) -> list[Record]:
    """Return what receivers recorded beside an IMU's file said, in order of reading."""
    found = [path for path in sorted(file.parent.glob("gnss_*.mcap")) if not path.name.startswith("gnss_session_")]
    return sorted(chain.from_iterable(map(read_fixes, found)), key=lambda record: record.host_ns)


def recorded_aid(file: Path) -> str:
    """Return the aid that a recording was monitored with, empty where its folder does not say.

    Raises
    ------
    DataRefused
        If the folder's table of events cannot be read.
    """
    path = file.parent / EVENTS_FILE
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            return next((row.get("text") or "" for row in csv.DictReader(stream) if row.get("event") == "aid"), "")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataRefused(path, None, f"no readable table ({error})", f"the {EVENTS_FILE} of a run") from error
