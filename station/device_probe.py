"""Read an IMU, a MAVLink link or a camera for some seconds and report what it sends; nothing is recorded."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.camera import CameraDecoder, CameraImage
from drivers.camera.decoder import CameraCounters
from drivers.camera.jpeg import jpeg_size
from drivers.errors import LinkSilent, ReplayEnded, WrongFormat
from drivers.framing import Decoder, seen_instead, sniff
from drivers.mavlink.session import MavlinkPort, RequestedMessage
from drivers.port_interface import Port
from drivers.ports import open_port, wire_of
from drivers.wire import FORMATS, FrameCounters, WireFormat
from procedures.counts.sample_records import SampleBlock
from station.stream.connected_unit import receiver_address
from station.stream.gnss_feed import GnssFeed
from station.stream.live.stream_trouble import SilentChannels
from station.stream.reader import Chunk
from station.stream.reader.messages import StreamGap
from station.text import plural

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

    Raise `DriverError` if the port cannot be opened, no byte comes, no frame of any format is among them, or a
    DBC or a mapping breaks a rule.
    """
    address = parse_device_url(url)
    known = wire_of(address)  # a wrong DBC or mapping is reported before a port is waited for
    data, took = read_for(open_port(address), seconds)
    if not data:
        raise LinkSilent(address.name, seconds, address.baud)
    likely = sniff(data)
    wire = known or (FORMATS[likely[0].format] if likely else None)
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


class _Direct:
    """A port as a source, in this process."""

    def __init__(self, address: DeviceAddress, port: MavlinkPort) -> None:
        self.address: DeviceAddress = address
        self._port = port
        self.bytes = 0
        self.up_to_ns = 0

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        data = self._port.read(READ_BYTES)
        self.bytes += len(data)
        self.up_to_ns = time.time_ns()
        return [Chunk(self.up_to_ns, data)] if data else []


@dataclass(frozen=True, slots=True)
class GnssProbe:
    """What came of a link, and what was asked of it."""

    feed: GnssFeed
    asked: Sequence[RequestedMessage]

    def lines(self) -> list[str]:
        """Return it in lines."""
        systems = [f"system {n}: {count} frames" for n, count in sorted(self.feed.decoder.systems.items())]
        asked = [f"{one.message} at {one.rate_hz:g} Hz: {one.outcome}" for one in self.asked]
        return ["format    MAVLink", *systems, *asked, self.feed.summary]


def probe_gnss(url: str, seconds: float, fixes: float = float("inf")) -> GnssProbe:
    """Return what came within ``seconds``, or until there were as many positions as ``fixes``.

    Raise `DriverError` if the port cannot be opened, no byte comes, or no frame is among them.
    """
    address = receiver_address(url)
    port = open_port(address)
    assert isinstance(port, MavlinkPort)
    try:
        source = _Direct(address, port)
        feed, until = GnssFeed(source), time.monotonic() + seconds
        while time.monotonic() < until and ((site := feed.site()) is None or site.fixes < fixes):
            feed.advance()
    finally:
        port.close()
    if not source.bytes:
        raise LinkSilent(address.name, seconds, address.baud, "check cable, address and power")
    counters = feed.decoder.framer.counters
    if not counters.frames + counters.refused:
        raise WrongFormat(address.name, "MAVLink", source.bytes, address.baud)
    return GnssProbe(feed, port.session.asked)


FORMAT = "MJPEG"


@dataclass(frozen=True, slots=True)
class CameraProbe:
    """What came within ``seconds``; ``rate_hz`` is by the sender's stamps, None where it sends none.

    ``sizes`` are the images' widths and heights [px], one unless they change.
    """

    seconds: float
    bytes: int
    images: int
    sizes: tuple[tuple[int, int], ...]
    rate_hz: float | None
    counters: CameraCounters

    @property
    def size(self) -> str:
        """Width and height [px] in words."""
        return ", then ".join(f"{width} x {height} px" for width, height in self.sizes)

    @property
    def errors(self) -> dict[str, int]:
        """What the decoder counted in addition to images."""
        counters = self.counters
        return {"cut": counters.cut, "not_jpeg": counters.not_jpeg, "skipped_bytes": counters.skipped_bytes}

    def lines(self) -> list[str]:
        """Return it in lines."""
        rate = "no stamps" if self.rate_hz is None else f"{self.rate_hz:.6g} Hz by its own time"
        return [
            f"format    {FORMAT}",
            f"size      {self.size}",
            f"received  {self.images / self.seconds:.1f} images/s, {self.bytes / self.seconds:.0f} bytes/s",
            f"rate      {rate}",
            f"errors    {_troubles(self.counters)}",
        ]


def _troubles(counters: CameraCounters) -> str:
    cut, other, skipped = plural(counters.cut, "image"), plural(counters.not_jpeg, "part"), counters.skipped_bytes
    return f"{cut} cut short or broken, {other} of another kind, {plural(skipped, 'byte')} in no image"


def probe_camera(url: str, seconds: float, timeout_s: float = 0.05) -> CameraProbe:
    """Read a camera for ``seconds``.

    Raise `DriverError` if it cannot be opened, no byte comes, or no image is among them.
    """
    address = parse_device_url(url, "camera")
    decoder, images, came = CameraDecoder(), list[CameraImage](), 0
    port = open_port(address, timeout_s)
    began = time.monotonic()
    try:
        while (took := time.monotonic() - began) < seconds:
            data = port.read(READ_BYTES)
            came += len(data)
            images += decoder.feed(data, time.monotonic_ns())
    finally:
        port.close()
    if not came:
        raise LinkSilent(address.name, seconds, advice="check that the camera is on and not in use elsewhere")
    if not images:
        seen = f"{_troubles(decoder.counters)}; look for longer, or check what it sends"
        raise WrongFormat(address.name, "JPEG", came, seen=seen)
    sizes = tuple(dict.fromkeys(jpeg_size(image.jpeg) for image in images))
    return CameraProbe(took, came, len(images), sizes, _rate(images), decoder.counters)


def _rate(images: list[CameraImage]) -> float | None:
    stamps = np.array([image.device_ns for image in images if image.device_ns is not None], np.int64)
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    return float(1e9 / np.median(steps)) if len(steps) else None
