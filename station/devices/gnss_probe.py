"""A short look at a MAVLink link, recording nothing: who is there, what comes how often, where it stands."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.addresses import DeviceAddress
from drivers.errors import LinkSilent, WrongFormat
from drivers.mavlink.session import MavlinkPort, RequestedMessage
from drivers.ports import open_port
from station.devices.imu_probe import READ_BYTES
from station.stream.device_addresses import receiver_address
from station.stream.gnss.gnss_feed import GnssFeed
from station.stream.reader import Chunk, GapMark


class _Direct:
    """A port as a source, in this process."""

    def __init__(self, address: DeviceAddress, port: MavlinkPort) -> None:
        self.address: DeviceAddress = address
        self._port = port
        self.bytes = 0
        self.up_to_ns = 0

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
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

    Raises
    ------
    DriverError
        If the port cannot be opened, no byte comes, or no frame is among them.
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
