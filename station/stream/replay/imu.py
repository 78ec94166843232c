"""A recorded MCAP file as a source of chunks, as they came then, at their pace or faster."""

import time
from pathlib import Path

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import PortNotFound, ReplayEnded
from station.files.mcap_files import read_step
from station.stream.reader import Chunk, GapMark

MAGIC = b"\x89MCAP0"


def is_mcap(path: Path) -> bool:
    """Say whether a file begins as MCAP does; one that cannot be read does not."""
    try:
        with path.open("rb") as stream:
            return stream.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


class Replay:
    """Gives out a file's chunks ``speed`` times as fast as they came; 0: as fast as they are taken.

    Raises
    ------
    PortNotFound, DataRefused
        If the file holds no bytes of a device, or is damaged.
    """

    def __init__(self, url: str, speed: float = 1.0) -> None:
        self.address: DeviceAddress = parse_device_url(url)
        self._speed = speed
        self._chunks = [Chunk(host_ns, data) for host_ns, data in read_step(Path(self.address.name)).raw]
        if not self._chunks:
            raise PortNotFound(self.address.name, "holds no bytes of a device", "name a session or a recording")
        self._size = sum(len(chunk.data) for chunk in self._chunks)
        self._at, self._began = 0, time.monotonic()

    def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
        """Return the chunks that are due, waiting at most ``timeout_s``; raise `ReplayEnded` after the last."""
        if self._at == len(self._chunks):
            raise ReplayEnded(self.address.name, self._size)
        if not self._speed:
            self._at += 1
            return [self._chunks[self._at - 1]]
        wait = self._due(self._at) - time.monotonic()
        if wait > 0:
            time.sleep(min(wait, timeout_s))
        found = list[Chunk | GapMark]()
        while self._at < len(self._chunks) and self._due(self._at) <= time.monotonic():
            found.append(self._chunks[self._at])
            self._at += 1
        return found

    def _due(self, index: int) -> float:
        return self._began + (self._chunks[index].host_ns - self._chunks[0].host_ns) / 1e9 / self._speed
