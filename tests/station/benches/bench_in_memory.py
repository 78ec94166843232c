"""A simulated device polled in memory, in device time: no process, no port, no waiting."""

from collections.abc import Callable, Iterable
from pathlib import Path

from drivers.device_url import DeviceUrl, parse_device_url
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault, Silence
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.campaign import Fixture
from procedures.steps import Step, Turn
from station.benches import HeadlessBench, Progress, open_feed
from station.campaign_folder.schema import SiteTable
from station.reader import Chunk, GapMark
from station.recorder import open_campaign

SITE = SiteTable(latitude_deg=31.17, gravity_m_s2=9.80665)


class Source:
    """A device's bytes; an unplug is marked as the reader marks it."""

    def __init__(self, truth: Truth, faults: Iterable[Fault] = (), format: str = "counts") -> None:
        self.device = ByteDevice(truth, 1, format, faults)
        self.address: DeviceUrl = parse_device_url(f"serial:///dev/simulated?format={format}")
        self.polls = 0

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        self.polls += 1
        items = list[Chunk | GapMark]()
        for part in self.device.chunk():
            stamp = round(self.device.imu.time * 1e9)
            if isinstance(part, Silence):
                marks = [GapMark(stamp, "port lost", False), GapMark(stamp, "port back", True)]
                items += marks if part.unplugged else []
            else:
                items.append(Chunk(stamp, part))
        return items


class InstantHands:
    """Moves the cube of a device in memory; ``before`` is told of each command and may do something else."""

    def __init__(self, device: ByteDevice, before: Callable[[str], str | None] = lambda command: None) -> None:
        self.device, self._before = device, before

    def place(self, position: int) -> float | None:
        return self._say(f"place {position} 5")

    def turn(self, step: Turn) -> float | None:
        return self._say(f"turn {step.axis} {step.direction} {step.revolutions} {step.rest_s + 2}")

    def _say(self, command: str) -> float | None:
        answer = self.device.obey(self._before(command) or command)
        assert answer.startswith("ok"), answer
        return float(answer.split()[-1])


class Rig:
    """A headless bench with everything around it, in a folder."""

    def __init__(self, folder: Path, truth: Truth | None = None, faults: Iterable[Fault] = ()) -> None:
        self.folder = folder / "campaign"
        self.folder.mkdir()
        self.source = Source(Truth.example(1) if truth is None else truth, faults)
        self.feed = open_feed(self.source)
        self.unit = self.feed.identify()
        self.database = open_db(folder / "station.db")
        self.recorder = open_campaign(self.folder, self.unit, SITE, self.database)
        self.said = list[Progress]()
        self.hands = InstantHands(self.source.device)
        self.bench = self.bench_with(self.hands)

    def bench_with(self, hands: InstantHands) -> HeadlessBench:
        return HeadlessBench(self.feed, hands, self.recorder, Fixture().C_ib, self.said.append)

    def notes(self, step: Step) -> list[str]:
        return [p.note for p in self.said if p.step == step and p.note]
