"""What a reader beside the IMU told too late for its tick: `late.csv`, by which a replay counts it as it was."""

import csv
from collections.abc import Iterable
from pathlib import Path

from station.errors import DataRefused, cannot_write

LATE_FILE = "late.csv"
COLUMNS = ("stream", "read_ns", "counted_ns")
Late = dict[int, int]  # by the moment of reading [ns], the moment of the tick [ns] that took it


def note_late(folder: Path, stream: str, read_ns: Iterable[int], counted_ns: int) -> None:
    """Add what was read at some moments [ns] and counts from a later tick on.

    Raises
    ------
    CannotWrite
        If the disk refuses.
    """
    path = folder / LATE_FILE
    try:
        is_new = not path.exists()
        with path.open("a", newline="", encoding="utf-8") as table:
            rows = csv.writer(table)
            if is_new:
                rows.writerow(COLUMNS)
            rows.writerows((stream, read, counted_ns) for read in read_ns)
    except OSError as error:
        raise cannot_write(path, error) from error


def read_late(folder: Path, stream: str) -> Late:
    """Return what a stream told too late in the run that a folder holds; nothing where all came in time.

    A row that a kill cut short is left out.

    Raises
    ------
    DataRefused
        If there is a table that cannot be read.
    """
    path = folder / LATE_FILE
    try:
        with path.open(newline="", encoding="utf-8") as table:
            rows = [row for row in csv.reader(table) if len(row) == len(COLUMNS) and row[0] == stream]
        late = {int(read): int(counted) for _, read, counted in rows}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, csv.Error) as error:
        raise DataRefused(path, None, f"no readable table ({error})", f"the {LATE_FILE} of a run") from error
    return {read: counted for read, counted in late.items() if counted > read}
