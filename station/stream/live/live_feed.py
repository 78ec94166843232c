"""A live stream cut into blocks of a second, with everything watched that may go wrong with it."""

import contextlib
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from drivers.addresses import DeviceAddress
from drivers.errors import DriverError, LinkLost, LinkSilent, ReplayEnded, WrongFormat
from drivers.framing import seen_instead, sniff
from drivers.ports import wire_of
from drivers.wire import FORMATS, WireFormat
from procedures.campaign.campaign import UNKNOWN
from station.errors import DataRefused
from station.files.atomic_file import recording_path
from station.stream.connected_unit import Unit, not_another, refuse_other, unit_of
from station.stream.live.stillness import TICKS_PER_BLOCK, Block, block_of
from station.stream.live.stream_trouble import PowerWatch, SilentChannels, StreamTrouble
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.reader.messages import LOST
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_stream import DecodedChunk, SampleStream
from station.stream.recorder.sample_times import PulseAges

BLOCK_S = 1.0
MIN_HELD_SAMPLES = 10  # samples at least that a block waits for what would show that it is not the device's
POLL_S = 0.1
MAX_PULSES = 1000  # pulses that nobody takes
SILENT_S = 1.8  # of the station's time, without a byte or without a frame: it is to be reported within 2 s
RESNIFF_S = 1.0  # at what comes instead of frames: that takes time
JOINING_S = 6.0  # the same until the first sample of what must learn its period to join samples
REPLUG_S = 30.0  # how long a lost port may stay away
IDENTITY_S = 3.0  # of the device's time: how long to wait for the device to say who it is
SNIFFED_BYTES = 16384  # bytes
MIN_FRAMES = 3
TEMPERATURE_SAMPLES = 1000  # the newest samples; some devices send a temperature twice a second only


class ChunkSource(Protocol):
    """Where chunks come from: a reader process."""

    address: DeviceAddress

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        """Return what has come, within ``timeout_s``."""
        ...


class LiveFeed:
    """A device's samples on a `SampleBuffer`, and its blocks.

    ``unit`` is set by `identify`; from then on another unit's serial number is refused. ``clock`` [s] is the
    station's, by which it waits.
    """

    def __init__(
        self,
        source: ChunkSource,
        wire: WireFormat,
        held: Sequence[Chunk] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._source, self.wire = source, wire
        self.address = source.address
        self.unit: Unit | None = None
        self.stream, self.buffer, self._power = SampleStream(wire), SampleBuffer(), PowerWatch(wire)
        self._channels = SilentChannels()
        self._recent = b""
        self._silent_s = self._frameless_s = 0.0
        self._wrong: WrongFormat | None = None  # found so ...
        self._looked_s = 0.0  # ... after so long without a frame
        self._is_restarted = True
        self.lost = ""  # why the port is not there, empty where it is
        self.losses = 0  # how often it went away
        self.restarts = 0  # how often the device was switched off and on since the feed began
        self._clock, self._counters = clock, StreamTrouble(clock)
        self.trouble = ""  # what is amiss though samples come, and what to do; empty where nothing was for 2 s
        self._pieces: list[DecodedChunk] = []  # the last ones taken
        self.stamp: tuple[int, float] | None = None  # when the newest sample was read [ns], its device time [s]
        self._ages = PulseAges(wire.pulse)
        self.pulse_age: float | None = None  # s since a pulse, where the device reports it
        self._pulses = deque[float](maxlen=MAX_PULSES)  # their device times [s]; several may be of one
        for chunk in held:
            self._take(chunk)
        self._at = self._begin = self.buffer.begin

    @property
    def period(self) -> float:
        """The nominal sample period [s]: as the device states it, else as it was measured."""
        period = self.unit.period if self.unit else self.stream.period
        assert period is not None, "identify first"
        return period

    @property
    def gives_time(self) -> bool:
        """Whether the device sends a time that does not begin again as it runs."""
        return self.stream.decoder.kind.has_time and self.wire.time_modulus is None

    @property
    def amiss(self) -> str:
        """What is wrong with the line while nothing is raised: a port that is away, else `trouble`."""
        if not self.lost:
            return self.trouble
        return f"{self.address.name} was lost ({self.lost}); it is tried again and again: check cable and power"

    @property
    def silent(self) -> str:
        """Which channels have put out one value for a while, and what to do; empty where all change."""
        period = self.unit.period if self.unit else self.stream.period
        return self._channels.text(period, self.stream.decoder.kind.channels) if period else ""

    @property
    def temperature_c(self) -> float | None:
        """The newest temperature, None where the device says none."""
        end = self.buffer.end
        if end <= self.buffer.first:
            return None
        values = self.buffer.block(max(self.buffer.first, end - TEMPERATURE_SAMPLES), end).temperature
        known = values[np.isfinite(values)]
        return float(known[-1]) if len(known) else None

    def identify(self, model: str | None = None, serial: str | None = None, *, has_begun: bool = False) -> Unit:
        """Wait until it is known which unit this is; see `unit_of` for what it raises.

        The wait for a serial number is of the device's time, so that a replay ends in what the live run did. Raise
        `DataRefused` if a replayed file ends before it is known how often samples come.
        """
        decoder, kind = self.stream.decoder, self.wire.identity
        is_identity = kind is not None and kind is not self.wire.imu
        while (period := self.stream.period) is None or (
            is_identity and not decoder.serial and self.stream.counters.samples * period < IDENTITY_S
        ):
            try:
                self.advance()
            except ReplayEnded as error:
                if period is None:
                    raise no_recording(error, self.wire.name) from error
                break
        self.unit = unit_of(
            self.address.name, decoder.identity, round(period, 9), model, serial, has_begun=has_begun
        )
        return self.unit

    def identify_or_unknown(self, model: str | None, serial: str | None) -> Unit:
        """Do the same with what was typed, if anything; a device that never says who it is may stay unknown."""
        unknown = UNKNOWN if self.wire.identity is None else None
        return self.identify(model or unknown, serial or unknown)

    def blocks(self) -> Iterator[Block]:
        """Yield the stream's blocks of a second, for ever; a block never reaches over a break."""
        while True:
            yield from self.ready()
            self.advance()

    def ready(self) -> Iterator[Block]:
        """Yield the blocks that are complete by now and were not yielded before.

        What is amiss shows after the fact, as when another device's sample came before the device's own: so a
        block waits a moment, and what stands shortly before a break is not used.
        """
        while True:
            size = max(TICKS_PER_BLOCK, round(BLOCK_S / self.period))
            held = max(MIN_HELD_SAMPLES, round(self.wire.hindsight_s / self.period))
            if self._begin != self.buffer.begin:
                self._at = self._begin = self.buffer.begin
                self._is_restarted = True
            self._at = max(self._at, self.buffer.first)  # what was let go is in no block
            if self.buffer.end - self._at < size + held:
                return
            if (broken := self.buffer.last_break(self._at, self._at + size + held)) is not None:
                self._at = broken
            else:
                first, self._at = self._at, self._at + size
                is_restarted, self._is_restarted = self._is_restarted, False
                is_broken = self.buffer.last_break(first - 1, first + 1) is not None
                yield self._block(first, self._at, is_broken=is_broken, is_restarted=is_restarted)

    def newest(self) -> Block | None:
        """Return the last second as a block of its own, for a look in between; None if it is not whole."""
        size = max(TICKS_PER_BLOCK, round(BLOCK_S / self.period))
        first = self.buffer.end - size
        if (
            first < max(self.buffer.begin, self.buffer.first)
            or self.buffer.last_break(first, self.buffer.end) is not None
        ):
            return None
        return self._block(first, self.buffer.end, is_broken=False, is_restarted=False)

    def _block(self, first: int, last: int, *, is_broken: bool, is_restarted: bool) -> Block:
        samples = self.buffer.block(first, last)
        return block_of(samples, first, self.period, is_broken=is_broken, is_restarted=is_restarted)

    def pieces(self, look: Callable[[], None] = lambda: None) -> Iterator[DecodedChunk]:
        """Yield the stream's pieces, for ever; samples are not kept. ``look`` is called often, whatever comes."""
        while True:
            yield from self._pieces
            self.buffer.forget_before(self.buffer.end)
            look()
            self.advance()

    def advance(self) -> None:
        """Take what has come, waiting for it a moment.

        Raises
        ------
        LinkSilent, WrongFormat, LinkLost
            No byte for 2 s; bytes but no frame for 2 s; the port stays away for 30 s.
        UnitChanged
            If another unit answers than the one identified.
        """
        began = self._clock()
        items = self._source.poll(POLL_S)
        waited = self._clock() - began
        self._pieces.clear()
        frames = self.stream.decoder.counters.frames
        for item in items:
            if isinstance(item, StreamGap):
                self._mark(item)
                waited = 0.0  # it was not for this port
            else:
                self._silent_s = 0.0
                self._recent = (self._recent + item.data)[-SNIFFED_BYTES:]
                self._take(item)
        self.trouble = self._counters.look(self.stream)
        if self.unit is not None:
            refuse_other(self.address.name, self.stream.decoder.identity, self.unit)
        self._watch(waited, is_idle=not items, has_frames=self.stream.decoder.counters.frames > frames)

    def _take(self, chunk: Chunk) -> None:
        self._pieces.append(piece := self.stream.take(chunk))
        self._channels.take(piece.block)
        age = self._ages.of(chunk.data, piece.block)
        self.restarts += self._power.take(piece, self.stream.period, has_time=self.stream.decoder.kind.has_time)
        if len(piece.block):
            self.stamp = chunk.host_ns, (at := float(piece.block.device_time[-1]))
            self.pulse_age = age
            if piece.restart_at is not None:
                self._pulses.clear()
            if age is not None:
                self._pulses.append(at - age)
        self.buffer.append(self._pieces[-1])

    def pulses(self, until_s: float) -> list[float]:
        """Return the times [s] of the pulses until a device time [s], of those since the last call."""
        found = list[float]()
        while self._pulses and self._pulses[0] <= until_s:
            found.append(self._pulses.popleft())
        return found

    def replace_source(self, source: ChunkSource) -> None:
        """Continue with another reader of the same device; the stream restarts."""
        self._source = source
        self.reset()

    def reset(self) -> None:
        """Let go what came last, as another unit's, and take what comes next as a new beginning."""
        self.stream.reset()
        self.buffer.reset()
        self._silent_s = self._frameless_s = 0.0

    def _mark(self, mark: StreamGap) -> None:
        self.lost = "" if mark.is_open else mark.reason.removeprefix(LOST) or "gone"
        self.losses += not mark.is_open
        self._silent_s = self._frameless_s = 0.0
        self.stream.reset()

    def _watch(self, waited_s: float, *, is_idle: bool, has_frames: bool) -> None:
        """Add up the time waited in vain; a station that was itself held up did not wait."""
        self._silent_s += waited_s if is_idle else 0.0
        self._frameless_s = 0.0 if has_frames else self._frameless_s + waited_s
        self._wrong = None if has_frames else self._wrong
        name, baud = self.address.name, self.address.baud
        is_joining = self.wire.passed_over and not self.stream.counters.samples
        if self.lost:
            if self._silent_s > REPLUG_S:
                raise LinkLost(name, f"{self.lost}, not back within {REPLUG_S:g} s")
        elif self._silent_s >= SILENT_S:
            raise LinkSilent(name, SILENT_S, baud)
        elif self._frameless_s >= (JOINING_S if is_joining else SILENT_S):
            if self._wrong is None or self._frameless_s >= self._looked_s + RESNIFF_S:
                self._wrong, self._looked_s = self._what_comes_instead(), self._frameless_s
            raise self._wrong

    def _what_comes_instead(self) -> WrongFormat:
        address, recent = self.address, self._recent
        likely = next((found.format for found in sniff(recent) if found.format != self.wire.name), None)
        seen = seen_instead(self.wire, recent)
        return WrongFormat(address.name, self.wire.name, len(recent), address.baud, likely, seen)


def open_feed(source: ChunkSource) -> LiveFeed:
    """Return the feed of a source in the format its address says, else in the one its first bytes look like.

    Raises
    ------
    BadDeviceUrl
        If it is the address of something else.
    LinkSilent, WrongFormat
        If the format must be found and no byte comes for 2 s, or no frame of any.
    DataRefused
        If it must be found and a replayed file ends before.
    """
    address = not_another(source.address)
    if (wire := wire_of(address)) is not None:
        return LiveFeed(source, wire)
    held, deadline = list[Chunk](), time.monotonic() + SILENT_S
    while time.monotonic() < deadline:
        try:
            held += [item for item in source.poll(POLL_S) if isinstance(item, Chunk)]
        except ReplayEnded as error:
            raise no_recording(error, "any known format") from error
        data = b"".join(chunk.data for chunk in held)[:SNIFFED_BYTES]
        found = sniff(data) if data else []
        if found and found[0].frames >= MIN_FRAMES:
            return LiveFeed(source, FORMATS[found[0].format], held)
    if not held:
        raise LinkSilent(address.name, SILENT_S, address.baud)
    size = sum(len(chunk.data) for chunk in held)
    raise WrongFormat(address.name, "", size, address.baud)


def no_recording(ended: ReplayEnded, wanted: str) -> DataRefused:
    """Return the refusal of a replayed file that is at its end before it was known what it is."""
    found = f"{ended.size} bytes without enough frames of {wanted}"
    return DataRefused(ended.path, None, found, "bytes as a device sent them", "name a recording")


RETRY_S = 1.0  # between two tries to read a port whose reader died


class RestartableReader:
    """Reads ``url`` into recordings of ``folder``; `restart` has the reader of ``feed`` begin again."""

    def __init__(self, url: str, folder: Path) -> None:
        self._url, self._folder = url, folder
        self.reader = Reader(url, recording_path(folder))
        self.reader.start()
        self.feed: LiveFeed | None = None
        self._retry_at = 0.0

    def restart(self) -> None:
        """Begin it again, if it has ended and a second has passed."""
        if self.feed is None or self.reader.ended is None or time.monotonic() < self._retry_at:
            return
        self._retry_at = time.monotonic() + RETRY_S
        self.reader.close()
        self.reader = Reader(self._url, recording_path(self._folder))
        with contextlib.suppress(DriverError):  # tried again and again
            self.reader.start()
            self.feed.replace_source(self.reader)

    def close(self) -> None:
        """End the reader."""
        self.reader.close()
