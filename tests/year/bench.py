"""A slab with a cube and a port: the unit that is connected, and what it has sent."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from drivers.errors import PortBusy, PortNotFound
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Silence
from drivers.simulated.truth import Truth
from procedures.arrays import IntArray
from procedures.counts.sample_records import CountBlock
from procedures.frames import rotation_vector
from station.stream.reader.messages import LOST, Chunk, Item, StreamGap
from tests.year.clock import HostClock

STEP_S = 0.25  # in which time goes on
ADDRESS = "serial:///dev/ttyYEAR?format=counts"
PORT = "/dev/ttyYEAR"


@dataclass
class PowerOn:
    """One power-on: every count that the unit put out, by sample, and what its clock was set back by, in turn."""

    device: ByteDevice
    began: float
    blocks: list[CountBlock] = field(default_factory=list)
    clock_off: list[float] = field(default_factory=lambda: [0.0])

    def counts(self) -> IntArray:
        """Return gyros and accelerometers (n, 6)."""
        parts = [np.hstack((block.gyro, block.accel)) for block in self.blocks]
        return np.concatenate(parts) if parts else np.zeros((0, 6), np.int64)


class Bench:
    """A unit on a port, in the machine's time; ``ppm`` is how much faster the unit's clock goes."""

    def __init__(self, clock: HostClock, truth: Truth, seed: int, ppm: float) -> None:
        self._clock, self.truth, self._seed, self._ppm = clock, truth, seed, ppm
        self.power_ons: list[PowerOn] = []
        self.others: list[ByteDevice] = []  # another unit, while it is at the port
        self._items = deque[Item]()
        self._is_open = self._is_lost = False
        self._back_at = self._swap_until = 0.0  # when the port is there again; until when another unit is
        self._since_ns = 0
        self.switch_on(1)

    @property
    def now(self) -> PowerOn:
        """What is powered."""
        return self.power_ons[-1]

    @property
    def device(self) -> ByteDevice:
        """The unit of the campaign."""
        return self.now.device

    @property
    def position(self) -> int:
        """The position in which the cube rests, 0 while it is carried or leans."""
        return 0 if self.device.imu.is_moving else self.device.imu.position

    @property
    def tilt(self) -> float:
        """How far the cube stands from where its face would lie on the clean slab [rad], 0 while it is carried."""
        imu = self.device.imu
        if not self.position:
            return 0.0
        up = imu._segments[-1].C_bn[:, 2]  # noqa: SLF001  no one but the harness may know
        return float(np.linalg.norm(up - imu.world.attitude(self.position)[:, 2]))

    @property
    def turned(self) -> float:
        """How far the cube is turned about the vertical off its marks [rad], 0 while it is carried."""
        imu = self.device.imu
        if not self.position:
            return 0.0
        off = imu._segments[-1].C_bn.T @ imu.world.attitude(self.position)  # noqa: SLF001  as above
        return abs(float(rotation_vector(off)[2]))

    def switch_on(self, position: int) -> None:
        """Switch the unit on, as it stands."""
        device = ByteDevice(self.truth, 1000 * self._seed + len(self.power_ons), "counts")
        self.power_ons.append(PowerOn(device, self._clock.now))
        read, kept = device.imu.read, self.now.blocks

        def remembered(samples: int) -> CountBlock:
            block = read(samples)
            kept.append(block)
            return block

        device.imu.read = remembered  # type: ignore[method-assign]
        if position != 1:
            device.execute(f"place {position} 1")

    def say(self, command: str) -> str:
        """Have the hands do something; return what they answer."""
        answer = self.device.execute(command)
        if not answer.startswith("ok"):
            raise AssertionError(f"{command}: {answer}")
        return answer

    def swap(self, other: Truth, seconds: float) -> None:
        """Put another unit to the port, for so long, and back."""
        self.others = [ByteDevice(other, self._seed + 7, "counts")]
        self._unplug(1.0)
        self._swap_until = self._clock.now + 1.0 + seconds

    def unplug(self, seconds: float) -> None:
        """Take the port away for so long."""
        self._unplug(seconds)

    def open(self) -> None:
        """Open the port; raise `PortNotFound` while it is away, `PortBusy` where it is open."""
        if self._clock.now < self._back_at:
            raise PortNotFound(PORT, "no such port", "check the cable")
        if self._is_open:
            raise PortBusy(PORT)
        self._is_open, self._is_lost = True, False
        self._items.clear()
        self._since_ns = round(self._clock.ahead * 1e9)

    def close(self) -> None:
        """Let the port go."""
        self._is_open = False

    def stamp(self) -> int:
        """Return the machine's time as a reader that began when the port was opened says it [ns]."""
        return self._since_ns + round(self._clock.now * 1e9)

    def taken(self) -> list[Item]:
        """Return what has come since the last call."""
        items = list(self._items)
        self._items.clear()
        return items

    def go_on(self) -> None:
        """Put out what is due by now."""
        due = self._due(self.now)
        while (missing := due - self.device.samples) > 0:
            self._send(self.device, min(50, missing), is_away=bool(self.others))
        if self._clock.now >= self._back_at and self._is_lost:
            self._is_lost = False
            self._mark("port back", is_open=True)
        if self.others:
            self._send(self.others[0], max(1, round(STEP_S / self.truth.sample_period_s)), is_away=False)
            if self._clock.now > self._swap_until:
                self.others = []
                self._unplug(1.0)

    def _due(self, power: PowerOn) -> int:
        seconds = (self._clock.now - power.began) * (1 + 1e-6 * self._ppm)
        return int(seconds / self.truth.sample_period_s)

    def _send(self, device: ByteDevice, samples: int, *, is_away: bool) -> None:
        for part in device.chunk(samples):
            if isinstance(part, Silence):
                if part.kind == "unplug":
                    self._unplug(part.seconds)
            elif self._is_open and not self._is_lost and not is_away:
                self._items.append(Chunk(self.stamp(), part))
        if device is self.device:
            off = device._faulty._clock_off  # noqa: SLF001  what the unit's clock says is off by
            if off != self.now.clock_off[-1]:
                self.now.clock_off.append(off)

    def _unplug(self, seconds: float) -> None:
        self._back_at = max(self._back_at, self._clock.now + seconds)
        if self._is_open and not self._is_lost:
            self._is_lost = True
            self._mark(f"{LOST}unplugged", is_open=False)

    def _mark(self, reason: str, *, is_open: bool) -> None:
        if self._is_open:
            self._items.append(StreamGap(self.stamp(), reason, is_open))
