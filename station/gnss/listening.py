"""A short look at a MAVLink link, recording nothing: who is there, what comes how often."""

import time

from drivers.device_url import DeviceUrl
from drivers.errors import LinkSilent, WrongFormat
from drivers.mavlink.address import MavlinkUrl
from drivers.mavlink.port import MavlinkPort
from drivers.ports import open_port, parse_device_url
from station.gnss.feed import GnssFeed
from station.gnss.summary import summary
from station.reader import Chunk, GapMark

READ_BYTES = 65536


class _Direct:
    """A port as a source, in this process."""

    def __init__(self, address: MavlinkUrl, port: MavlinkPort) -> None:
        self.address: DeviceUrl = address
        self._port = port
        self.bytes = 0
        self.up_to_ns = 0

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        data = self._port.read(READ_BYTES)
        self.bytes += len(data)
        self.up_to_ns = time.time_ns()
        return [Chunk(self.up_to_ns, data)] if data else []


def listen(url: str, seconds: float) -> list[str]:
    """Return what came within ``seconds``, in lines.

    Raises
    ------
    DriverError
        If the port cannot be opened, no byte comes, or no frame is among them.
    """
    address = parse_device_url(url)
    assert isinstance(address, MavlinkUrl)
    port = open_port(address)
    assert isinstance(port, MavlinkPort)
    try:
        source = _Direct(address, port)
        feed, until = GnssFeed(source), time.monotonic() + seconds
        while time.monotonic() < until:
            feed.advance()
    finally:
        port.close()
    if not source.bytes:
        raise LinkSilent(address.name, seconds, address.baud)
    counters = feed.decoder.framer.counters
    if not counters.frames + counters.refused:
        raise WrongFormat(address.name, "MAVLink", source.bytes, address.baud)
    systems = [f"system {n}: {count} frames" for n, count in sorted(feed.decoder.systems.items())]
    asked = [f"{one.message} at {one.rate_hz:g} Hz: {one.outcome}" for one in port.session.asked]
    return ["format    MAVLink", *systems, *asked, summary(feed)]
