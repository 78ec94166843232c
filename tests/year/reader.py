"""The reader of the simulated port, in this process: it records as the real one and dies when it is told to."""

from pathlib import Path

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import DriverError, LinkLost
from station.errors import CannotWrite, cannot_write
from station.files.mcap_files.schemas import RAW, RAW_TOPIC, SCHEMA
from station.files.mcap_files.writer import GrowingFile, new_channel
from station.stream.reader.messages import Item
from station.stream.reader.raw_recording import SESSION, RawRecording
from tests.year.machine import Machine


class InlineRecording(RawRecording):
    """A recording that is written where it is told, without a thread; what the dead hold back stays unwritten."""

    def __init__(self, path: Path, machine: Machine) -> None:
        GrowingFile.__init__(self, path)
        self._machine = machine
        try:
            self._writer.add_metadata(SESSION, {"url": "simulated"})
            self._raw = new_channel(self._writer, RAW_TOPIC, RAW, SCHEMA)
            self.flush()
        except OSError as error:
            raise cannot_write(path, error) from error

    def put(self, item: Item) -> None:
        """Write it."""
        self._write(item)

    def close(self) -> None:
        """Finish the file, if there is somebody to do it."""
        if not self._machine.disk.is_dead:
            self.finish()
        self._stream.close()


class InProcessReader:
    """As `station.stream.reader.Reader`, of the machine's one port."""

    def __init__(self, machine: Machine, url: str, recording: Path | None) -> None:
        self._machine, self.recording = machine, recording
        self.address: DeviceAddress = parse_device_url(url)
        self.ended: DriverError | CannotWrite | None = None
        self._recording: InlineRecording | None = None
        self._is_open = False
        self._polls = 0

    def start(self) -> None:
        """Open port and recording."""
        self._machine.bench.open()
        self._is_open = True
        self._machine.reader_dies = False
        try:
            self._recording = None if self.recording is None else InlineRecording(self.recording, self._machine)
        except BaseException:
            self.close()
            raise

    def poll(self, timeout_s: float) -> list[Item]:
        """Let time pass and return what has come in it."""
        if self.ended is not None:
            raise self.ended
        self._machine.sleep(max(timeout_s, self._machine.pace_s))
        if self._machine.reader_dies:
            self.ended = LinkLost(self.address.name, "the reader process ended, exit code -9")
            self.close()
            raise self.ended
        items = self._machine.bench.taken()
        self._keep(items)
        return items

    def _keep(self, items: list[Item]) -> None:
        if self._recording is None:
            return
        try:
            for item in items:
                self._recording.put(item)
            self._polls += 1
            if self._polls % 8 == 0:
                self._recording.flush()
        except OSError as error:
            self.ended = cannot_write(self._recording.path, error)
            raise self.ended from error

    def close(self) -> None:
        """Let port and recording go; may be called twice."""
        if self._is_open:
            self._is_open = False
            self._machine.bench.close()
            if self._recording is not None:
                try:
                    self._recording.close()
                except OSError as error:
                    self.ended = cannot_write(self._recording.path, error)


class ProbePort:
    """The machine's port as a look at it opens it."""

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        machine.bench.open()

    def read(self, max_bytes: int) -> bytes:
        """Return what comes in a moment."""
        self._machine.sleep(0.1)
        return b"".join(getattr(item, "data", b"") for item in self._machine.bench.taken())

    def write(self, data: bytes) -> None:
        """Take it."""

    def close(self) -> None:
        """Give the port back."""
        self._machine.bench.close()
