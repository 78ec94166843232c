"""A GNSS receiver alongside the IMU: its reader process, its fixes, its message rates, and what is wrong with it.

A receiver whose bytes come but mean nothing is found within 2 s, with a line that says what to do.
"""

import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from drivers.addresses import MavlinkAddress
from drivers.errors import BadDeviceUrl
from drivers.mavlink.frames import SignatureCheck, read_key
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from procedures.gnss_records import AveragedSite, FixType, GnssFix, TimeMark, averaged_site
from station.files.atomic_file import recording_path
from station.files.mcap_files.gnss_file import FixWriter, Record
from station.stream.auxiliary import (
    SILENT_S,  # heartbeats are a second apart
    CompanionSource,
    LiveCompanion,
)
from station.stream.connected_unit import RECEIVER, receiver_address
from station.stream.gnss_fix_times import UtcLine
from station.stream.reader import Chunk, StreamGap
from station.stream.reader.reader import RestartingReader
from station.stream.stream_events import StreamState
from station.text import plural

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


MAX_MESSAGES = 6000  # messages
RATE_S = 5.0
MIN_EXPECTED_MESSAGES = 5  # messages expected of a rate that is judged
SETTLING_S = 8.0  # until all was asked for, three times and the old way
SLOW_SHARE, WELL_SHARE = 0.6, 0.7  # of the rate asked for: below and above
WATCHED = ("GPS_RAW_INT", "SYSTEM_TIME")  # position and time; a sender may have no more than these


class MessageRates:
    """Watches one system's messages; times are of the station's monotonic clock [s]."""

    def __init__(self, name: str, asked_hz: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._name, self._asked_hz, self._clock = name, asked_hz, clock
        self._seen: deque[tuple[float, str]] = deque(maxlen=MAX_MESSAGES)
        self._names: set[str] = set()
        self._well_since = clock()
        self._slow: dict[str, str] = {}
        self._window_s = max(RATE_S, MIN_EXPECTED_MESSAGES / asked_hz)

    @property
    def trouble(self) -> str:
        """Which message is slow, and what to do; empty where none is."""
        return next(iter(self._slow.values()), "")

    def came(self, name: str) -> None:
        """Take note of a message."""
        self._seen.append((self._clock(), name))
        self._names.add(name)

    def hz(self, window_s: float = RATE_S) -> dict[str, float]:
        """Return how often each message came over the last seconds."""
        since = self._clock() - window_s
        counts = Counter(name for at, name in self._seen if at >= since)
        return {name: count / window_s for name, count in counts.items()}

    def look(self, *, is_well: bool) -> None:
        """Say what is slow now; where something else is wrong, or was until lately, nothing is."""
        now = self._clock()
        if not is_well:
            self._well_since = now
        if now - self._well_since < SETTLING_S + self._window_s:
            self._slow.clear()
            return
        rates = self.hz(self._window_s)
        for name in WATCHED:
            rate = rates.get(name, 0.0)
            if rate > WELL_SHARE * self._asked_hz:
                self._slow.pop(name, None)
            elif rate < SLOW_SHARE * self._asked_hz and name in self._names:
                self._take(name, rate)

    def _take(self, name: str, rate: float) -> None:
        """Note a slow message; its rate as it was found, so that the words do not change all the time."""
        asked = f"{self._asked_hz:g} Hz was asked for"
        if not rate:
            self._slow[name] = f"{self._name}: {name} no longer comes, {asked}; check receiver and autopilot"
        elif name not in self._slow:
            self._slow[name] = (
                f"{self._name}: {name} comes at {rate:.2g} Hz, {asked}; let autopilot and receiver send it as "
                f"often, or ask for less: rate={max(rate, 0.1):.1g} in the address"
            )


MAX_FIXES = 6000  # fixes: 20 minutes at 5 Hz


class GnssFeed(LiveCompanion[Record]):
    """One receiver, read and decoded; call `advance` often."""

    def __init__(
        self,
        source: CompanionSource,
        writer: FixWriter | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(source, MAX_FIXES, clock)
        address = source.address
        if address.scheme != "mavlink":
            raise BadDeviceUrl(address.text, f"scheme {address.scheme!r}", RECEIVER)
        check = SignatureCheck(read_key(address.key_file)) if address.key_file else None
        self.decoder = MavlinkDecoder(address.system, check)
        self.fixes: deque[GnssFix] = deque(maxlen=MAX_FIXES)
        self.latest: GnssFix | None = None
        self._fix_at, self._writer = clock(), writer
        self._utc = UtcLine()
        self._stamps_are_marks = True  # of fixes, until the sender states its time
        self._wrong, self._watch = "", GnssTrouble(address, clock)
        self._rates = MessageRates(address.name, address.rate_hz, clock)

    def _hear(self, items: Sequence[Chunk | StreamGap]) -> None:
        for item in items:
            if not isinstance(item, StreamGap):
                self._take_bytes(item)
            elif self._writer is not None:
                self._writer.mark(item.host_ns, item.reason, is_open=item.is_open)
        wrong = self._watch.look(self.decoder, self.latest)
        self._wrong = self._gone("MAVLink; check cable, address and power") or wrong
        self._rates.look(is_well=not self._wrong)

    @property
    def trouble(self) -> str:
        """What is wrong, found within 2 s (a low rate later), and what to do; empty if nothing is."""
        return self._wrong or self._rates.trouble

    def stream(self) -> StreamState:
        """Return its health."""
        counters = self.decoder.framer.counters
        return StreamState(
            name=f"GNSS {self.address.name}", rate_hz=max(self._rates.hz().values(), default=0.0),
            age_s=self._clock() - self._fix_at, samples=len(self.fixes), gaps=0, lost=counters.lost,
            bad=counters.bad_crc, trouble=self.trouble,
        )  # fmt: skip

    @property
    def summary(self) -> str:
        """Fixes, where, how often and what was refused, in a line."""
        site, counters = self.site(), self.decoder.framer.counters
        where = "no position" if site is None else site_in_words(site)
        rates = ", ".join(f"{name} {rate:.1f} Hz" for name, rate in sorted(self._rates.hz().items()))
        return (
            f"{self.address.name}: system {self.decoder.system or 'none'}, "
            f"{plural(len(self.fixes), 'fix')}, {where}; {rates or 'nothing of late'}; "
            f"{counters.bad_crc} bad check, {counters.lost} lost, {counters.refused} refused, "
            f"{plural(counters.skipped_bytes, 'byte')} in no frame" + (f"; {self.trouble}" if self.trouble else "")
        )

    def site(self) -> AveragedSite | None:
        """Return where the receiver stands, of its first antenna; None before a fix."""
        first = [fix for fix in self.fixes if fix.source == "GPS_RAW_INT"]
        return averaged_site(first or list(self.fixes))

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s since 1970] at a moment of the station's clock [ns]; None where it is not known."""
        return self._utc.utc(host_ns)

    def utc_scatter(self) -> float:
        """Return the 1 sigma [s, UTC] of one mark about the line that `utc` read last; 0 before there is one."""
        return self._utc.scatter

    def _take_bytes(self, chunk: Chunk) -> None:
        for record in self.decoder.feed(chunk.data, chunk.host_ns):
            match record:
                case GnssFix():
                    self._rates.came(record.source)
                    if not record.is_filtered:
                        self._take_fix(record)
                case TimeMark(host_ns, _, utc_ns):
                    self._rates.came("SYSTEM_TIME")
                    if utc_ns is not None:
                        self._mark(host_ns, utc_ns, is_stated=True)
            if isinstance(record, Record):
                self._waiting.append(record)
                if self._writer is not None:
                    self._writer.write(record)

    def _take_fix(self, fix: GnssFix) -> None:
        self.fixes.append(fix)
        self.latest, self._fix_at = fix, self._clock()
        if fix.utc_ns is not None and self._stamps_are_marks and fix.has_position:
            self._mark(fix.host_ns, fix.utc_ns, is_stated=False)

    def _mark(self, host_ns: int, utc_ns: int, *, is_stated: bool) -> None:
        if is_stated and self._stamps_are_marks:  # a fix's stamp is earlier than its message by a latency unknown
            self._stamps_are_marks = False
            self._utc.reset()
        self._utc.mark(host_ns, utc_ns)


@contextmanager
def open_gnss(url: str, folder: Path | None) -> Iterator[GnssFeed]:
    """Read a receiver by a process of its own while the ``with`` lasts; its files go to a ``folder``, if any.

    ``gnss_session_*.mcap`` has every byte (topic ``/gnss/raw``), ``gnss_*.mcap`` what they say, and gap marks. A
    reader process that dies is replaced by another, with a session file of its own.

    Raises
    ------
    DriverError, CannotWrite
        What address, port or disk refuse.
    """
    with RestartingReader(receiver_address(url).text, folder) as reader:
        if folder is None:
            yield GnssFeed(reader)
            return
        with closing(FixWriter(recording_path(folder, "gnss"))) as writer:
            yield GnssFeed(reader, writer)


def site_in_words(site: AveragedSite) -> str:
    """Return latitude, longitude and height with their 1 sigma."""
    where = f"{np.degrees(site.latitude):.6f}, {np.degrees(site.longitude):.6f} deg"
    if site.height is None or site.vertical_std is None:
        return f"{where}, u {site.horizontal_std:.1f} m, no height"
    return f"{where}, {site.height:.1f} m, u {site.horizontal_std:.1f} m, height {site.vertical_std:.1f} m"
