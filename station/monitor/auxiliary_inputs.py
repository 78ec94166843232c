"""What the monitor reads alongside the IMU: aids by GNSS or airspeed, camera, wheel; and the IMU stream's health.

Records are merged with the IMU's samples by the moments at which both were read, so that a replay gives the same
to the last bit. The age of a velocity is the delay of its message, by the sender's clock (else `USUAL_LATENCY`),
and the time since it was read. A receiver without vertical velocity is taken not to climb.
"""

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import monotonic
from typing import TypeVar

from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from procedures.gnss_records import AirData, FixType, GnssFix
from station.attitude.live_kalman_filter import NO_AID, AidValues
from station.files.mcap_files.gnss_file import Record
from station.stream.auxiliary import Companion, came_ns
from station.stream.live.live_feed import LiveFeed
from station.stream.stream_events import StreamState

USUAL_LATENCY = 0.1  # s; of most receivers 0.1 to 0.2 s


SILENT_S = 10.0  # of the device, without a value of the aid
EXPECTED = {
    "airspeed-filter": ("no airspeed", "VFR_HUD with airspeed from an autopilot", "--aid gnss"),
    "gnss": ("no GNSS velocity", "GPS_RAW_INT with speed and course", "--aid none"),
}


class AidSilence:
    """Reports once that an aid is silent; the filter continues without it."""

    def __init__(self, aid: str) -> None:
        self._aid, self._since, self._is_reported = aid, math.nan, False

    def look(self, aiding: AidValues, t: float) -> str:
        """Take what the aid reported until device time ``t`` [s]; return what to report, empty if nothing."""
        if self._aid not in EXPECTED or self._is_reported:
            return ""
        if math.isnan(self._since) or t < self._since or aiding is not NO_AID:
            self._since = t
        if t - self._since < SILENT_S:
            return ""
        self._is_reported = True
        found, expected, instead = EXPECTED[self._aid]
        return f"{found} for {SILENT_S:.0f} s, expected {expected}; check --gnss, or use {instead}"


def aiding_of(records: Sequence[Record], aid: str, host_ns: int) -> AidValues:
    """Return the newest of what ``aid`` is about among records until a moment [ns], nan where there is nothing."""
    if aid == "airspeed-filter":
        airs = [record for record in records if isinstance(record, AirData)]
        return AidValues(airspeed=airs[-1].airspeed) if airs else NO_AID
    if aid == "gnss":
        for record in reversed(records):
            if isinstance(record, GnssFix) and (velocity := _velocity(record)) is not None:
                latency = USUAL_LATENCY if record.latency is None else record.latency
                age = max((host_ns - record.host_ns) / 1e9 + latency, 0.0)
                heading = math.nan if record.heading is None else record.heading
                return AidValues(velocity=velocity, heading=heading, age=age)
    return NO_AID


def _velocity(fix: GnssFix) -> tuple[float, float, float] | None:
    """Return a fix's velocity north, east, down [m/s]; None where it has none, or is filtered by its sender."""
    horizontal = fix.velocity_n
    if horizontal is None or fix.fix < FixType.FIX_2D or fix.is_filtered:
        return None
    east, north = horizontal
    return north, east, -(fix.v_up or 0.0)


MAX_HOLD_S = 0.1  # that a tick waits for a reader once it lags: a well one says each 0.05 s that nothing came
NoteLate = Callable[[str, Iterable[int], int], None]
T = TypeVar("T", bound=Record | CameraImage | WheelReading)


@dataclass(frozen=True, slots=True)
class AuxiliaryData:
    """What came until the end of a tick."""

    records: Sequence[Record] = ()
    images: Sequence[CameraImage] = ()
    wheel: Sequence[WheelReading] = ()


@dataclass(slots=True)
class AuxiliaryReaders:
    """Receiver, camera and wheel. ``note_late_messages`` receives by name what counts in a later tick.

    On a busy machine a message may arrive after its tick: it counts in the next one, in a replay too.
    """

    gnss: Companion[Record] | None = None
    camera: Companion[CameraImage] | None = None
    wheel: Companion[WheelReading] | None = None
    note_late_messages: NoteLate = lambda stream, read_ns, counted_ns: None
    _until_ns: int = 0  # the end of the last tick
    _lags_since: dict[str, float] = field(default_factory=dict)  # by name, those behind now

    def advance(self) -> None:
        """Take what has come."""
        for each in self._readers.values():
            each.advance()

    def streams(self) -> tuple[StreamState, ...]:
        """Return how each does."""
        return tuple(each.stream() for each in self._readers.values())

    def has_everything(self, host_ns: int) -> bool:
        """Return whether all read until a moment [ns] is here; who lags is waited for once, and not for long."""
        now = monotonic()
        behind = [name for name, each in self._readers.items() if each.up_to_ns < host_ns]
        self._lags_since = {name: self._lags_since.get(name, now) for name in behind}
        return all(now - since > MAX_HOLD_S for since in self._lags_since.values())

    def take(self, now_ns: int) -> AuxiliaryData:
        """Return what came since the last tick and until the end [ns] of this one."""
        until_ns = max(now_ns, self._until_ns + 1)  # a tick may seem to end before the last: a delay is learnt
        data = AuxiliaryData(
            self._taken("gnss", self.gnss, until_ns),
            self._taken("camera", self.camera, until_ns),
            self._taken("wheel", self.wheel, until_ns),
        )
        self._until_ns = until_ns
        return data

    def _taken(self, name: str, each: Companion[T] | None, until_ns: int) -> Sequence[T]:
        if each is None:
            return ()
        found = each.take(until_ns)
        if self._until_ns and (late := sorted({at for at in map(came_ns, found) if at <= self._until_ns})):
            self.note_late_messages(name, late, until_ns)
        return found

    @property
    def _readers(self) -> dict[str, Companion[Record] | Companion[CameraImage] | Companion[WheelReading]]:
        named = {"gnss": self.gnss, "camera": self.camera, "wheel": self.wheel}
        return {name: each for name, each in named.items() if each is not None}


RATE_WINDOW_S = 5.0


class StreamHealth:
    """Looks at one feed; ``trouble`` is what it last refused, empty while it is well."""

    def __init__(self, feed: LiveFeed, clock: Callable[[], float] = time.monotonic) -> None:
        self._feed, self._clock = feed, clock
        self._seen: deque[tuple[float, int]] = deque([(clock(), 0)])
        self._came = clock()
        self.unhealthy = 0
        self.trouble = ""

    def look(self) -> StreamState:
        """Return the stream's health now."""
        now, counters = self._clock(), self._feed.stream.counters
        if counters.samples > self._seen[-1][1]:
            self._came = now
        self._seen.append((now, counters.samples))
        while now - self._seen[0][0] > RATE_WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()
        seconds = now - self._seen[0][0]
        framing = self._feed.stream.decoder.counters
        return StreamState(
            name=f"IMU {self._feed.wire.name}",
            rate_hz=(counters.samples - self._seen[0][1]) / seconds if seconds > 0 else 0.0,
            age_s=now - self._came, samples=counters.samples, gaps=counters.breaks + counters.restarts,
            lost=counters.lost, bad=framing.bad_crc + framing.bad_length, unhealthy=self.unhealthy,
            trouble=self.trouble,
        )  # fmt: skip
