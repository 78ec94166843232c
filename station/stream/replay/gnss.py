"""The receiver of a recording: its files stand beside the IMU's."""

import csv
from itertools import chain
from pathlib import Path

from procedures.earth.gnss_records import GnssFix
from station.errors import DataRefused
from station.files.mcap_files.fix_reader import Record, read_fixes
from station.stream.beside import RecordedCompanion
from station.stream.counted_late import read_late
from station.stream.stream_events import EVENTS_FILE


def recorded_gnss(file: Path) -> RecordedCompanion[Record] | None:
    """Return the receiver recorded beside an IMU's file; None where there was none."""
    records = read_recorded_fixes(file)
    late = read_late(file.parent, "gnss")
    return RecordedCompanion("GNSS", iter(records), late, _is_fix) if records else None


def _is_fix(record: Record) -> bool:
    return isinstance(record, GnssFix) and not record.is_filtered


def read_recorded_fixes(file: Path) -> list[Record]:
    """Return what receivers recorded beside an IMU's file said, in order of reading."""
    found = [path for path in sorted(file.parent.glob("gnss_*.mcap")) if not path.name.startswith("gnss_session_")]
    return sorted(chain.from_iterable(map(read_fixes, found)), key=lambda record: record.host_ns)


def recorded_choice(file: Path, event: str) -> str:
    """Return what a recording was monitored with, "aid" or "laws", empty where its folder does not say.

    Raises
    ------
    DataRefused
        If the folder's table of events cannot be read.
    """
    path = file.parent / EVENTS_FILE
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            return next((row.get("text") or "" for row in csv.DictReader(stream) if row.get("event") == event), "")
    except FileNotFoundError:
        return ""
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataRefused(path, None, f"no readable table ({error})", f"the {EVENTS_FILE} of a run") from error
