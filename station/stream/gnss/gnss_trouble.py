"""What is wrong with a GNSS receiver or its link, found within 2 s, in a line that says what to do."""

import time
from collections.abc import Callable

from drivers.mavlink.decoder import MavlinkDecoder
from procedures.earth.gnss_records import FixType, GnssFix
from station.stream.reader.messages import LOST

SILENT_S = 1.8  # it is to be said within 2 s; heartbeats are a second apart
STILL_COMING_S = 0.9  # frames of others after the last one read


class GnssTrouble:
    """Watches counters; times are of the station's monotonic clock [s]. Messages were asked for at ``rate_hz``."""

    def __init__(
        self, name: str, system: int | None, rate_hz: float, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._name, self._system, self._clock = name, system, clock
        self._first_s = max(SILENT_S, 3 / rate_hz)  # how long the first fix may take
        self._began = self._bytes_at = self._frames_at = self._read_at = self._fix_at = clock()
        self._frames = self._refused = self._read = 0
        self._away = ""
        self.ended = ""
        self.trouble = ""

    def gap(self, reason: str, *, is_open: bool) -> None:
        """Take note that the port went or came."""
        self._away = "" if is_open else reason
        self._bytes_at = self._clock()

    def bytes_came(self) -> None:
        """Take note that bytes came."""
        self._bytes_at = self._clock()

    def look(self, decoder: MavlinkDecoder, latest: GnssFix | None) -> None:
        """Say what is wrong now."""
        now, counters = self._clock(), decoder.framer.counters
        refused = counters.refused > self._refused
        if counters.frames > self._frames:
            self._frames_at = now
        if (read := decoder.messages.total()) > self._read:
            self._read_at = now
        if latest is not None and latest.fix >= FixType.FIX_2D:
            self._fix_at = now
        self._frames, self._refused, self._read = counters.frames, counters.refused, read
        self.trouble = self._said(now, decoder, latest, was_refused=refused)

    def _said(self, now: float, decoder: MavlinkDecoder, latest: GnssFix | None, *, was_refused: bool) -> str:
        name, counters = self._name, decoder.framer.counters
        if self.ended:
            return self.ended
        if self._away:
            remedy = "check cable and power" if self._away.startswith(LOST) else "nothing is to be done"
            return f"{name}: {self._away}; it is tried again and again: {remedy}"
        if now - self._bytes_at >= SILENT_S:
            return f"{name}: no bytes for {SILENT_S:g} s, expected MAVLink; check cable, address and power"
        if now - self._frames_at >= SILENT_S:
            if counters.refused:
                return (
                    f"{name}: {counters.unsigned} frames unsigned, {counters.bad_signature} wrongly signed, "
                    f"{counters.replayed} replayed, expected frames signed with the key given; check key and clock"
                )
            return f"{name}: bytes hold no MAVLink frame, expected some; check the baud rate"
        if now - self._read_at >= SILENT_S and self._frames_at - self._read_at >= STILL_COMING_S:
            there = ", ".join(str(system) for system in sorted(decoder.systems))
            wanted = self._system or "an autopilot's heartbeat"
            return f"{name}: system {there} is there, expected {wanted}; give system=N in the address"
        if latest is None and now - self._began >= self._first_s:
            return f"{name}: no GNSS message, expected GPS_RAW_INT; check that a receiver is connected"
        if latest is not None and now - self._fix_at >= SILENT_S:
            seen = "" if latest.satellites is None else f" ({latest.satellites} satellites)"
            return f"{name}: no fix{seen}, expected one; give the antenna a view of the sky"
        return ""
