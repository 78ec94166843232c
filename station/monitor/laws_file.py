"""What each law read, tick by tick, beside a recording: `laws.csv`. A replay into a folder writes it again."""

import csv
from pathlib import Path
from typing import TextIO

from station.errors import cannot_write
from station.live_attitude.readings import difference
from station.monitor.view import MonitorView

LAWS_FILE = "laws.csv"


class LawsFile:
    """A table of roll and pitch [deg] by law, and of the angle between them; opened with the first row."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / LAWS_FILE
        self._stream: TextIO | None = None

    def write(self, view: MonitorView) -> None:
        """Write a row; raise `CannotWrite` if the disk refuses."""
        assert view.reading is not None
        apart = difference(view.laws)
        row = [view.reading.t, view.reading.sample]
        for law in view.laws:
            row += [law.roll, law.pitch]
        try:
            rows = csv.writer(self._stream or self._opened(view))
            rows.writerow([*map(repr, row), *([] if apart is None else map(repr, apart))])
        except OSError as error:
            raise cannot_write(self._path, error) from error

    def close(self) -> None:
        """Finish the table; what comes after is added to it."""
        if self._stream is not None:
            self._stream.close()
        self._stream = None

    def _opened(self, view: MonitorView) -> TextIO:
        is_new = not self._path.exists()
        self._stream = self._path.open("a", newline="", encoding="utf-8", buffering=1)
        if is_new:
            names = [f"{law.law}_{angle}_deg" for law in view.laws for angle in ("roll", "pitch")]
            apart = ["difference_roll_deg", "difference_pitch_deg", "difference_angle_deg"]
            csv.writer(self._stream).writerow(["t_s", "sample", *names, *(apart if len(view.laws) > 1 else [])])
        return self._stream
