"""A short look at what a device sends, recording nothing."""

import time
from dataclasses import dataclass

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.errors import LinkSilent, ReplayEnded, WrongFormat
from drivers.framing import Decoder, seen_instead, sniff
from drivers.port_interface import Port
from drivers.ports import open_port, wire_of
from drivers.wire import FORMATS, FrameCounters, WireFormat
from procedures.counts.sample_records import SampleBlock
from station.stream.live.silent_channels import SilentChannels

READ_BYTES = 65536


@dataclass(frozen=True, slots=True, eq=False)
class ImuProbe:
    """What came within ``seconds``; ``rate_hz`` is by the device's own time, None if it sends none.

    ``channels`` are those that it measures; the others are 0 in ``samples``.
    """

    format: str
    model: str | None
    serial: str | None
    seconds: float
    bytes: int
    frames: int
    rate_hz: float | None
    counters: FrameCounters
    samples: SampleBlock
    channels: frozenset[str]

    @property
    def silent(self) -> str:
        """Which measured channels put out one value all the while though they could not, and what to do."""
        watch, period = SilentChannels(), 1 / self.rate_hz if self.rate_hz else self.seconds / self.frames
        watch.take(self.samples)
        return watch.text(period, self.channels, self.frames * period)


def probe_imu(url: str, seconds: float) -> ImuProbe:
    """Read a device for ``seconds``; where its address names no format, find the one that fits best.

    Raises
    ------
    DriverError
        If the port cannot be opened, no byte comes, no frame of any format is among them, or a DBC or a mapping
        breaks a rule.
    """
    address = parse_device_url(url)
    told = wire_of(address)  # a wrong DBC or mapping is said before a port is waited for
    data, took = read_for(open_port(address), seconds)
    if not data:
        raise LinkSilent(address.name, seconds, address.baud)
    likely = sniff(data)
    wire = told or (FORMATS[likely[0].format] if likely else None)
    seen = probe_bytes(wire, data, took) if wire else None
    if seen is None:
        wanted = wire.name if wire else ""
        instead = seen_instead(wire, data) if wire else ""
        if address.scheme == "replay":
            instead = instead or "name a file of bytes as a device sent them"
        raise WrongFormat(
            address.name, wanted, len(data), address.baud, likely[0].format if likely else None, instead
        )
    return seen


def probe_bytes(wire: WireFormat, data: bytes, seconds: float) -> ImuProbe | None:
    """Return what ``data``, come within ``seconds``, holds of a format; None where it holds none of its frames."""
    decoder = Decoder(wire)
    block = decoder.feed(data)
    if not len(block):
        return None
    steps = np.diff(block.device_time)
    steps = steps[np.isfinite(steps) & (steps > 0)]
    rate = float(1 / np.median(steps)) if len(steps) else None
    return ImuProbe(
        wire.name, decoder.model, decoder.serial, seconds, len(data), len(block), rate, decoder.counters, block,
        decoder.kind.channels,
    )  # fmt: skip


def read_for(port: Port, seconds: float) -> tuple[bytes, float]:
    """Return what comes within ``seconds``, and how long that took [s]; close the port."""
    parts, began = list[bytes](), time.monotonic()
    try:
        while time.monotonic() < began + seconds:
            parts.append(port.read(READ_BYTES))
    except ReplayEnded:
        pass
    finally:
        port.close()
    return b"".join(parts), max(time.monotonic() - began, 1e-9)
