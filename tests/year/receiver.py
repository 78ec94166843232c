"""A GNSS receiver next to the unit, in the machine's time, and the reader of its port in this process."""

from contextlib import suppress
from pathlib import Path

from drivers.address_parsing import parse_device_url
from drivers.simulated.companions.gnss_server import Autopilot
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from station.errors import cannot_write
from station.stream.reader.messages import Chunk, Item
from tests.year.machine import Machine
from tests.year.reader import InlineRecording

ADDRESS = "mavlink:udpin:127.0.0.1:14550"


class Receiver:
    """What stands next to the bench; UTC is the true one, whatever the machine's wall clock does."""

    def __init__(self, machine: Machine, truth: Truth, seed: int) -> None:
        self._machine = machine
        self.faults: list[TimedFault] = []
        epoch = AutopilotTruth(epoch_utc=machine.clock.wall - machine.clock.now, default_hz=2.0, states_utc=True)
        self._autopilot = Autopilot(truth, epoch, self.faults, seed=seed)

    def fails(self, kind: str, seconds: float, size: float) -> None:
        """Let something be wrong from now on."""
        self.faults.append(TimedFault(kind, self._machine.clock.now, seconds, size))

    def sent(self) -> bytes:
        """Return what it has sent since it was last asked."""
        return self._autopilot.due(self._machine.clock.now)


class InProcessReceiverReader:
    """As `station.stream.reader.Reader`, of the receiver."""

    def __init__(self, machine: Machine, url: str, recording: Path | None) -> None:
        self._machine, self._path = machine, recording
        self.address, self.up_to_ns = parse_device_url(url), 0
        self._recording: InlineRecording | None = None

    def start(self) -> None:
        """Open its recording."""
        self._recording = None if self._path is None else InlineRecording(self._path, self._machine)

    def poll(self, timeout_s: float) -> list[Item]:
        """Return what has come; let time pass where somebody waits for it."""
        if timeout_s > 0:
            self._machine.sleep(timeout_s)
        self.up_to_ns = self._machine.bench.stamp()
        receiver = self._machine.receiver
        data = receiver.sent() if receiver is not None else b""
        items: list[Item] = [Chunk(self.up_to_ns, data)] if data else []
        if self._recording is not None:
            try:
                for item in items:
                    self._recording.put(item)
            except OSError as error:
                raise cannot_write(self._recording.path, error) from error
        return items

    def close(self) -> None:
        """Let its recording go."""
        if self._recording is not None:
            with suppress(OSError):  # the process that has it says so to nobody and ends
                self._recording.close()
            self._recording = None
