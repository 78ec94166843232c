"""What is wrong with a GNSS receiver whose bytes come, found within 2 s, in a line that says what to do."""

from collections.abc import Callable

from drivers.addresses import MavlinkAddress
from drivers.mavlink.decoder import MavlinkDecoder
from procedures.earth.gnss_records import FixType, GnssFix
from station.stream.beside import SILENT_S  # heartbeats are a second apart

REPEATED_S = 5.0  # s of one stamp: an autopilot repeats the fix of a slow receiver for one or two
STILL_COMING_S = 0.9  # frames of others after the last one read


class GnssTrouble:
    """Watches counters; times are of the station's monotonic clock [s]."""

    def __init__(self, address: MavlinkAddress, clock: Callable[[], float]) -> None:
        self._address, self._clock = address, clock
        self._first_s = max(SILENT_S, 3 / address.rate_hz)  # how long the first fix may take
        self._began = self._frames_at = self._read_at = self._fix_at = clock()
        self._frames = self._read = 0
        self._stamp: tuple[int | None, int | None] = None, None  # of the latest fix
        self._stamp_ns = 0  # of the station's clock, when the first fix of that stamp was read

    def look(self, decoder: MavlinkDecoder, latest: GnssFix | None) -> str:
        """Return what is wrong now."""
        now, counters, name = self._clock(), decoder.framer.counters, self._address.name
        if counters.frames > self._frames:
            self._frames_at = now
        if (read := decoder.messages.total()) > self._read:
            self._read_at = now
        if latest is not None and latest.fix >= FixType.FIX_2D:
            self._fix_at = now
        if latest is not None and (latest.device_ns, latest.utc_ns) != self._stamp:
            self._stamp, self._stamp_ns = (latest.device_ns, latest.utc_ns), latest.host_ns
        self._frames, self._read = counters.frames, read
        if now - self._frames_at >= SILENT_S:
            if counters.refused:
                return (
                    f"{name}: {counters.unsigned} frames unsigned, {counters.bad_signature} wrongly signed, "
                    f"{counters.replayed} replayed, expected frames signed with the key given; check key and clock"
                )
            return f"{name}: bytes hold no MAVLink frame, expected some; check the baud rate"
        if now - self._read_at >= SILENT_S and self._frames_at - self._read_at >= STILL_COMING_S:
            there = ", ".join(str(system) for system in sorted(decoder.systems))
            wanted = self._address.system or "an autopilot's heartbeat"
            return f"{name}: system {there} is there, expected {wanted}; give system=N in the address"
        if latest is None and now - self._began >= self._first_s:
            return f"{name}: no GNSS message, expected GPS_RAW_INT; check that a receiver is connected"
        if latest is not None and now - self._fix_at >= SILENT_S:
            if latest.no_place:
                return f"{name}: no position: {latest.no_place}; wait for a fix, or check what sends it"
            seen = "" if latest.satellites is None else f" ({latest.satellites} satellites)"
            return f"{name}: no fix{seen}, expected one; give the antenna a view of the sky"
        repeated = (
            0.0 if latest is None or self._stamp == (None, None) else (latest.host_ns - self._stamp_ns) / 1e9
        )
        if repeated >= REPEATED_S:
            return (
                f"{name}: fixes repeat one moment for {repeated:.0f} s, expected new ones; the receiver no longer "
                "sends: check its cable, or restart it"
            )
        return ""
