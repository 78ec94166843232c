"""Columns read from one data file, before they are given a meaning."""

from collections.abc import Mapping
from dataclasses import dataclass

from procedures.arrays import FloatArray

TRIADS = {"gyro": ("gx", "gy", "gz"), "accel": ("ax", "ay", "az")}
OUTPUTS = TRIADS["gyro"] + TRIADS["accel"]
MAX_EXACT_INTEGER = 2**53  # integers below it are exact in float64
PLAUSIBLE_C = (
    -100.0,
    400.0,
)  # degC: beyond it no IMU works, and 0x7FFF in hundredths, a dead thermometer, is within


@dataclass(frozen=True, slots=True, eq=False)
class DataFile:
    """A data file's columns by header name, each (n,) float64; whole counts are exact (below 2^53).

    ``first_line`` is the line (CSV) or message (MCAP) of row 0. ``host_span`` is the station's own time [ns]
    of the first and last row where the file has it. ``damage`` says what is missing of a recording cut short.
    """

    file: str
    columns: Mapping[str, FloatArray]
    first_line: int
    sha256: str
    host_span: tuple[int, int] | None = None
    damage: str | None = None

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values())))

    def line(self, row: int) -> int:
        """Return the line or message number of a row."""
        return self.first_line + int(row)
