"""Reference time beside the rows of a recording: of those that came last in a chunk, as they came.

Each is the reference's reading when the row was read, with the jitter of that reading, so that a fit over many of
them (`procedures.campaign.campaign`) sees how well they tell; a smooth line through them would hide it.

Where the device tells how long before a sample a pulse (PPS) came, that pulse is the reference: a whole second,
latched by the device itself to a microsecond. Which second it is says the reading of the first one, and the
device's own time from then on; where that reading was this machine's clock, it is read anew once UTC is known.
"""

from collections.abc import Callable

Utc = Callable[[int], float | None]
MIN_INTERVAL_NS = 50_000_000  # at most 20 rows a second
PULSED_NS = 3 * 10**9  # so long after a pulse nothing less is taken for a reference
MAX_PULSE_JITTER_S = 0.05  # s by which seconds may lie off each other by the device's own time


class RowTimes:
    """UTC [s] for chunks in order, from what a moment of the station's clock [ns] was in UTC.

    ``is_pulsed`` says whether pulses were what told the last one.
    """

    def __init__(self, utc: Utc | None) -> None:
        self._utc = utc
        self._next_ns = 0
        self._pulse: tuple[int, float] | None = None  # the second of the last one, and its device time [s]
        self._is_by_host = False  # that second
        self._pulsed_ns = -PULSED_NS
        self.is_pulsed = False

    def begin_anew(self) -> None:
        """Forget the last pulse: the device's time has no relation to what it was."""
        self._pulse, self._pulsed_ns = None, -PULSED_NS

    def of(self, host_ns: int, device_s: float = 0.0, pulse_age: float | None = None) -> float | None:
        """Return UTC of a chunk's last row; None where it is not known or the one before was just now.

        ``device_s`` is the row's own time, ``pulse_age`` how long before it a pulse came [s], None: not told.
        """
        if host_ns < self._next_ns:
            return None
        self.is_pulsed = pulse_age is not None or host_ns < self._pulsed_ns + PULSED_NS
        if pulse_age is not None:
            self._next_ns, self._pulsed_ns = host_ns + MIN_INTERVAL_NS, host_ns
            return self._second(host_ns, device_s - pulse_age, pulse_age) + pulse_age
        if self._utc is None or self.is_pulsed:
            return None
        self._next_ns = host_ns + MIN_INTERVAL_NS
        return self._utc(host_ns)

    def _second(self, host_ns: int, pulse_s: float, age: float) -> int:
        """Return which second a pulse is that came at the device's time ``pulse_s`` [s]."""
        if self._pulse is not None:
            second, at = self._pulse
            passed = round(pulse_s - at)
            off = abs(pulse_s - at - passed)
        # the first, after a gap that nothing counted, or of a time that went back
        is_lost = self._pulse is None or off > MAX_PULSE_JITTER_S or passed < 0
        if is_lost or self._is_by_host:
            read = None if self._utc is None else self._utc(host_ns)
            if is_lost or read is not None:
                second, passed = round((host_ns / 1e9 if read is None else read) - age), 0
            self._is_by_host = read is None
        self._pulse = second + passed, pulse_s
        return second + passed
