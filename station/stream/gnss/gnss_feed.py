"""A live GNSS receiver: fixes, site, time, and what is wrong with it. The IMU's stream never waits for it.

Filtered positions are written but are not among `GnssFeed.fixes`: they have already been mixed with another IMU.
"""

import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np

from drivers.errors import BadDeviceUrl
from drivers.mavlink.decoder import MavlinkDecoder
from drivers.mavlink.signing import SignatureCheck, read_key
from procedures.earth.gnss_records import AveragedSite, GnssFix, TimeMark, averaged_site
from station.files.mcap_files.fix_reader import Record
from station.files.mcap_files.fix_writer import FixWriter
from station.files.new_folder import journal_path
from station.stream.beside import CompanionSource, LiveCompanion
from station.stream.device_addresses import RECEIVER, receiver_address
from station.stream.gnss.gnss_trouble import GnssTrouble
from station.stream.gnss.message_rates import MessageRates
from station.stream.gnss.utc_line import UtcLine
from station.stream.reader import Chunk, GapMark
from station.stream.reader.restarting_reader import RestartingReader
from station.stream.stream_events import StreamState
from station.text.plural import plural

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

    def _hear(self, items: Sequence[Chunk | GapMark]) -> None:
        for item in items:
            if not isinstance(item, GapMark):
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
        """Return UTC [s since 1970] at a moment of the station's clock [ns]; None where the marks do not tell."""
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
            self._utc.begin_anew()
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
        with closing(FixWriter(journal_path(folder, "gnss"))) as writer:
            yield GnssFeed(reader, writer)


def site_in_words(site: AveragedSite) -> str:
    """Return latitude, longitude and height with their 1 sigma."""
    where = f"{np.degrees(site.latitude):.6f}, {np.degrees(site.longitude):.6f} deg"
    if site.height is None or site.vertical_std is None:
        return f"{where}, u {site.horizontal_std:.1f} m, no height"
    return f"{where}, {site.height:.1f} m, u {site.horizontal_std:.1f} m, height {site.vertical_std:.1f} m"
