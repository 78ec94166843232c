"""A monitored run on the disk: bytes and counts as any recording, and a table of what happened.

The reader's journal has every byte in any case; `recording.mcap` has what was recorded on request.
"""

import csv
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from drivers.wire import FrameKind, WireFormat
from station.errors import cannot_write
from station.files.flush_pace import FlushPace
from station.files.mcap_files import BY_OUTPUT, StepWriter
from station.files.new_folder import free_path
from station.files.sha256sums import append_hash
from station.monitor.laws_file import LawsFile
from station.monitor.view import MonitorView
from station.stream.counted_late import note_late
from station.stream.recorder.pulse_ages import PulseAges
from station.stream.recorder.row_times import RowTimes, Utc
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.stream_events import EVENTS_FILE

FLUSH_S = 0.2
EVENT_COLUMNS = ("utc", "device_s", "sample", "event", "text")


class MonitorRecording:
    """Writes into a folder, with reference time beside the rows where ``utc`` tells it.

    ``name`` is the file being written, empty while none is.
    """

    def __init__(self, folder: Path, wire: WireFormat, utc: Utc | None = None) -> None:
        self._folder, self._wire, self._times = folder, wire, RowTimes(utc)
        self._writer: StepWriter | None = None
        self._pace, self._begin = FlushPace(FLUSH_S), -1
        self._laws = LawsFile(folder)
        self.name = ""

    def begin(self) -> str:
        """Begin a file and return its name."""
        path = free_path(self._folder, "recording")
        self._writer, self.name = StepWriter(path, BY_OUTPUT[self._wire.output]), path.name
        self._pulses = PulseAges(self._wire.pulse)
        return self.name

    def take(self, buffer: SampleBuffer, first: int, last: int, kind: FrameKind) -> None:
        """Write the samples from ``first`` up to before ``last``, if a file is open.

        Raises
        ------
        CannotWrite
            If the disk refuses; what was flushed stays.
        """
        writer = self._writer
        if writer is None or first >= last:
            return
        if buffer.begin != self._begin:
            self._begin = buffer.begin
            self._times.begin_anew()
        try:
            for chunk, block in buffer.recording([(first, last)]):
                writer.write_raw(chunk.host_ns, chunk.data)
                age = self._pulses.of(chunk.data, block)
                if len(block):
                    at = float(block.device_time[-1])
                    utc_s = self._times.of(chunk.host_ns, at, age)
                    writer.write_block(chunk.host_ns, block, kind.triads, utc_s)
            if self._pace.is_due:
                with self._pace.flushing():
                    writer.flush()
        except OSError as error:
            raise cannot_write(writer.path, error) from error

    def end(self) -> str:
        """Finish the file and return its name, empty if none was open."""
        writer, name = self._writer, self.name
        self._writer, self.name = None, ""
        if writer is not None:
            append_hash(self._folder, name, writer.close())
        self._laws.close()
        return name

    def take_laws(self, view: MonitorView) -> None:
        """Write what the laws read, if a file is open; raise `CannotWrite` if the disk refuses."""
        if self.name and view.laws:
            self._laws.write(view)

    def note_late(self, stream: str, read_ns: Iterable[int], counted_ns: int) -> None:
        """Write what counts in a later tick than it was read in; raise `CannotWrite` if the disk refuses."""
        note_late(self._folder, stream, read_ns, counted_ns)

    def note(self, event: str, text: str, device_s: float, sample: int) -> None:
        """Write what happened; raise `CannotWrite` if the disk refuses."""
        path = self._folder / EVENTS_FILE
        try:
            is_new = not path.exists()
            with path.open("a", newline="", encoding="utf-8") as stream:
                rows = csv.writer(stream)
                if is_new:
                    rows.writerow(EVENT_COLUMNS)
                rows.writerow((datetime.now(UTC).isoformat(), f"{device_s:.6f}", sample, event, text))
        except OSError as error:
            raise cannot_write(path, error) from error
