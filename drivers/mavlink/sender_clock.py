"""The sender's clock: what its messages' times since boot are in UTC, and how late what it sends arrives.

GPS_RAW_INT is stamped with UTC or with the time since boot, as the sender likes; SYSTEM_TIME holds both (boot time
by design of ArduPilot, issue 626). A message is written the moment its boot time is read, so the least that a
message was later than its stamp is the link's own delay; a fix is later by its receiver's latency. A boot time
that goes back is a restart: all is learnt anew.
"""

from collections import deque

from procedures.earth.gnss_records import TimeMark

EPOCH_US = 10**15  # us; what is beyond is UTC (2001), what is below since boot (32 years)
REBOOT_NS = 10**9
BOOT_MODULUS_MS = 2**32  # of time_boot_ms: it begins anew after 49.7 days
WRAPS_WITHIN_MS = 60_000  # of the last mark; a time that begins anew after more is a restart
WINDOW_MARKS = 600  # marks: minutes, in which crystals drift apart by less than the link's jitter


class SenderClock:
    """Learns from SYSTEM_TIME marks; times in ns."""

    def __init__(self) -> None:
        self.reboots = 0
        self._utc_less_boot: int | None = None
        self._host_less_boot: deque[int] = deque(maxlen=WINDOW_MARKS)
        self._last_boot = 0

    def mark(self, host_ns: int, boot_ns: int, utc_ns: int | None) -> TimeMark:
        """Take a SYSTEM_TIME; ``utc_ns`` None while the sender does not know it."""
        if boot_ns < self._last_boot - REBOOT_NS:
            self.reboots += 1
            self._utc_less_boot = None
            self._host_less_boot.clear()
        self._last_boot = boot_ns
        if utc_ns is not None:
            self._utc_less_boot = utc_ns - boot_ns
        self._host_less_boot.append(host_ns - boot_ns)
        return TimeMark(host_ns, boot_ns, utc_ns)

    def since_boot_ns(self, boot_ms: int) -> int:
        """Return a ``time_boot_ms`` as a time since boot [ns] that goes on where the 32 bit begin anew."""
        last = self._last_boot // 10**6
        later = (boot_ms - last + WRAPS_WITHIN_MS) % BOOT_MODULUS_MS - WRAPS_WITHIN_MS
        return (last + later if later < WRAPS_WITHIN_MS and last + later >= 0 else boot_ms) * 10**6

    def times(self, stamp_us: int) -> tuple[int | None, int | None]:
        """Return a stamp [us, either kind] as UTC and as time since boot [ns], each None where not known."""
        offset, stamp = self._utc_less_boot, stamp_us * 1000
        if stamp_us == 0:
            return None, None
        if stamp_us > EPOCH_US:
            return stamp, None if offset is None else stamp - offset
        return None if offset is None else stamp + offset, stamp

    def latency(self, host_ns: int, boot_ns: int | None) -> float | None:
        """Return how much later [s] than a SYSTEM_TIME a message of this boot time arrived."""
        if boot_ns is None or not self._host_less_boot:
            return None
        return (host_ns - boot_ns - min(self._host_less_boot)) / 1e9
