"""Reference time beside the rows of a recording: of those that came last in a chunk, as they came.

Each is the reference's reading when the row was read, with the jitter of that reading, so that a fit over many of
them (`procedures.diagnosis.clock_rate_check`) sees how well they tell; a smooth line through them would hide it.
"""

from collections.abc import Callable

Utc = Callable[[int], float | None]
MIN_INTERVAL_NS = 50_000_000  # at most 20 rows a second


class RowTimes:
    """UTC [s] for chunks in order, from what a moment of the station's clock [ns] was in UTC."""

    def __init__(self, utc: Utc | None) -> None:
        self._utc = utc
        self._next_ns = 0

    def of(self, host_ns: int) -> float | None:
        """Return UTC of a chunk's last row; None where it is not known or the one before was just now."""
        if self._utc is None or host_ns < self._next_ns:
            return None
        self._next_ns = host_ns + MIN_INTERVAL_NS
        return self._utc(host_ns)
