"""A live GNSS receiver: fixes, site, time, and what is wrong with it. The IMU's stream never waits for it.

What a monitor aids itself with is `GnssFeed.latest` and `GnssFeed.take`; filtered positions are kept apart in
`GnssFeed.filtered` and aid nothing, since they have already been mixed with another IMU.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol

from drivers.device_url_parser import parse_device_url
from drivers.errors import BadDeviceUrl, DriverError
from drivers.mavlink.address import MavlinkUrl
from drivers.mavlink.decoder import MavlinkDecoder
from drivers.mavlink.signing import SignatureCheck, read_key
from procedures.earth.gnss_records import AirData, AveragedSite, GnssFix, TimeMark, averaged_site
from station.files.mcap_files.fix_reader import Record
from station.files.mcap_files.fix_writer import FixWriter
from station.stream.gnss.gnss_trouble import GnssTrouble
from station.stream.gnss.message_rates import MessageRates
from station.stream.gnss.utc_line import UtcLine
from station.stream.live.live_feed import ChunkSource
from station.stream.reader import Chunk, GapMark
from station.stream.reader.restarting_reader import FOR_EVER, RestartingReader

MAX_FIXES = 6000  # fixes: 20 minutes at 5 Hz

EXPECTED = "a GNSS source: mavlink:LINK:WHERE"


class GnssSource(ChunkSource, Protocol):
    """Where chunks come from: a reader process."""

    @property
    def up_to_ns(self) -> int:
        """The moment up to which all that came was polled [ns]."""
        ...


class GnssFeed:
    """One receiver, read and decoded; call `advance` often."""

    def __init__(
        self, source: GnssSource, writer: FixWriter | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        address = source.address
        if not isinstance(address, MavlinkUrl):
            raise BadDeviceUrl(address.text, f"scheme {address.scheme!r}", EXPECTED)
        check = SignatureCheck(read_key(address.key_file)) if address.key_file else None
        self.address = address
        self.decoder = MavlinkDecoder(address.system, check)
        self.fixes: deque[GnssFix] = deque(maxlen=MAX_FIXES)
        self.filtered: deque[GnssFix] = deque(maxlen=MAX_FIXES)
        self.latest: GnssFix | None = None
        self.air: AirData | None = None
        self._source, self._writer = source, writer
        self._taken = 0  # of the fixes since the beginning, what `take` has returned
        self._came = 0
        self._records: deque[Record] = deque(maxlen=MAX_FIXES)
        self._is_lost = False
        self._utc = UtcLine()
        self._stamps_are_marks = True  # of fixes, until the sender states its time
        self._health = GnssTrouble(address.name, address.system, address.rate_hz, clock)
        self._rates = MessageRates(address.name, address.rate_hz, clock)

    def advance(self, timeout_s: float = 0.0) -> None:
        """Take what has come; what is wrong stands in `trouble`, nothing is raised but `CannotWrite`."""
        try:
            items = self._source.poll(timeout_s)
        except DriverError as error:
            self._health.ended = str(error)
            return
        for item in items:
            if isinstance(item, GapMark):
                self._is_lost = not item.is_open
                self._health.gap(item.reason, is_open=item.is_open)
                if self._writer is not None:
                    self._writer.mark(item.host_ns, item.reason, is_open=item.is_open)
            else:
                self._take_bytes(item)
        self._health.look(self.decoder, self.latest)
        self._rates.look(is_well=not self._health.trouble)

    @property
    def trouble(self) -> str:
        """What is wrong, found within 2 s (a low rate later), and what to do; empty if nothing is."""
        return self._health.trouble or self._rates.trouble

    def take(self) -> list[GnssFix]:
        """Return the fixes that came since the last call, oldest first; filtered ones are not among them."""
        new = min(self._came - self._taken, len(self.fixes))
        self._taken = self._came
        return list(self.fixes)[len(self.fixes) - new :]

    @property
    def up_to_ns(self) -> int:
        """The moment [ns] up to which nothing more will come; for ever where the receiver is gone."""
        return FOR_EVER if self._is_lost or self._health.ended else self._source.up_to_ns

    def take_records(self, until_ns: int) -> list[Record]:
        """Return fixes, times and airspeeds that came since the last call and until a moment [ns], in order."""
        found = list[Record]()
        while self._records and self._records[0].host_ns <= until_ns:
            found.append(self._records.popleft())
        return found

    def site(self) -> AveragedSite | None:
        """Return where the receiver stands, of its first antenna; None before a fix."""
        first = [fix for fix in self.fixes if fix.source == "GPS_RAW_INT"]
        return averaged_site(first or list(self.fixes))

    def utc(self, host_ns: int) -> float | None:
        """Return UTC [s since 1970] at a moment of the station's clock [ns]; None where the marks do not tell."""
        return self._utc.utc(host_ns)

    def utc_scatter(self) -> float:
        """Return the 1 sigma [s, UTC] of one mark about the line that `utc` read last; 0 before there is one."""
        return self._utc.scatter

    def rates_hz(self) -> dict[str, float]:
        """Return how often each record came over the last seconds."""
        return self._rates.hz()

    def _take_bytes(self, chunk: Chunk) -> None:
        self._health.bytes_came()
        for record in self.decoder.feed(chunk.data, chunk.host_ns):
            match record:
                case GnssFix():
                    self._rates.came(record.source)
                    self._take_fix(record)
                case TimeMark(host_ns, _, utc_ns):
                    self._rates.came("SYSTEM_TIME")
                    if utc_ns is not None:
                        self._mark(host_ns, utc_ns, is_stated=True)
                case AirData():
                    self.air = record
                case _:
                    pass
            if isinstance(record, Record):
                self._records.append(record)
                if self._writer is not None:
                    self._writer.write(record)

    def _take_fix(self, fix: GnssFix) -> None:
        if fix.is_filtered:
            self.filtered.append(fix)
            return
        self.fixes.append(fix)
        self.latest = fix
        self._came += 1
        if fix.utc_ns is not None and self._stamps_are_marks and fix.has_position:
            self._mark(fix.host_ns, fix.utc_ns, is_stated=False)

    def _mark(self, host_ns: int, utc_ns: int, *, is_stated: bool) -> None:
        if is_stated and self._stamps_are_marks:  # a fix's stamp is earlier than its message by a latency unknown
            self._stamps_are_marks = False
            self._utc.begin_anew()
        self._utc.mark(host_ns, utc_ns)


@contextmanager
def open_gnss(url: str, folder: Path) -> Iterator[GnssFeed]:
    """Read a receiver by a process of its own while the ``with`` lasts; its files go to ``folder``.

    ``gnss_session_*.mcap`` has every byte (topic ``/gnss/raw``), ``gnss_*.mcap`` what they say, and gap marks. A
    reader process that dies is replaced by another, with a session file of its own.

    Raises
    ------
    DriverError, CannotWrite
        What address, port or disk refuse.
    """
    if (address := parse_device_url(url, "receiver")).scheme != "mavlink":
        raise BadDeviceUrl(url, f"scheme {address.scheme!r}", EXPECTED)
    with RestartingReader(address.text, folder) as reader:
        writer = FixWriter(folder / f"gnss_{datetime.now(UTC):%Y%m%dT%H%M%S%fZ}.mcap")
        try:
            yield GnssFeed(reader, writer)
        finally:
            writer.close()
