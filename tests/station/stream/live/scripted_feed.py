"""A live feed in memory that gets what a script says, when it says so."""

from collections import deque
from collections.abc import Iterable

from drivers.address_parsing import parse_device_url
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station.stream.live.live_feed import LiveFeed
from station.stream.reader import Chunk, StreamGap

Item = Chunk | StreamGap
NOISE = bytes(64)
GONE, BACK = StreamGap(5, "port lost: unplugged", False), StreamGap(6, "port back", True)
TRIAD = "triad:?x=serial:///dev/x&y=serial:///dev/y&z=serial:///dev/z"
PERIOD = 0.02


class Script:
    """Each poll takes some seconds of the station's and brings something; after the last, nothing comes."""

    def __init__(self, polls: Iterable[tuple[float, list[Item]]] = (), url: str = "") -> None:
        self.address = parse_device_url(url or "serial:///dev/imu?format=counts&baud=115200")
        self.polls = deque(polls)
        self.now = 0.0

    def poll(self, timeout_s: float) -> list[Item]:
        seconds, items = self.polls.popleft() if self.polls else (timeout_s, [])
        self.now += seconds
        return items

    def clock(self) -> float:
        return self.now


def feed_of(script: Script, format: str = "counts") -> LiveFeed:
    return LiveFeed(script, FORMATS[format], clock=script.clock)


def device(period: float = PERIOD, faults: Iterable[Fault] = (), format: str = "counts") -> ByteDevice:
    return ByteDevice(Truth(sample_period_s=period), 1, format, faults)


def chunks(one: ByteDevice, samples: int) -> list[Item]:
    """Return what a device sends, a chunk a sample."""
    found = list[Item]()
    while one.samples < samples:
        data = b"".join(part for part in one.chunk(1) if isinstance(part, bytes))
        found.append(Chunk(round(one.imu.time * 1e9), data))
    return found
