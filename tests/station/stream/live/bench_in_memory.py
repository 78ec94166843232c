"""A simulated device polled in memory, in device time: no process, no port, no waiting."""

from collections.abc import Iterable

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault, Silence
from drivers.simulated.truth import Truth
from station.files.campaign_folder.campaign_schema import SiteTable
from station.stream.reader import Chunk, StreamGap

SITE = SiteTable(latitude_deg=31.17, gravity_m_s2=Truth().local_gravity)


class Source:
    """A device's bytes; an unplug is marked as the reader marks it."""

    def __init__(
        self,
        truth: Truth,
        faults: Iterable[Fault] = (),
        format: str = "counts",
        seed: int = 1,
        *,
        pps: bool = False,
    ) -> None:
        self.device = ByteDevice(truth, seed, format, faults, pps=pps)
        self.address: DeviceAddress = parse_device_url(f"serial:///dev/simulated?format={format}")
        self.polls = 0

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        self.polls += 1
        items = list[Chunk | StreamGap]()
        for part in self.device.chunk():
            stamp = round(self.device.imu.time * 1e9)
            if isinstance(part, Silence):
                marks = [StreamGap(stamp, "port lost", False), StreamGap(stamp, "port back", True)]
                items += marks if part.kind == "unplug" else []
            else:
                items.append(Chunk(stamp, part))
        return items
