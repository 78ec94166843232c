"""A monitored run on the disk: bytes and counts as any recording, a table of events, and `laws.csv`.

`laws.csv` holds what each attitude filter read, tick by tick; a replay into a folder writes it again.
"""

from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from drivers.wire import FrameKind, WireFormat
from station.attitude.live_readings import difference
from station.errors import cannot_write
from station.files.atomic_file import FlushInterval, add_rows, free_path
from station.files.mcap_files import BY_OUTPUT, StepWriter
from station.files.sha256sums import append_hash
from station.monitor.view import MonitorView
from station.stream.auxiliary import note_late_messages
from station.stream.recorder.sample_buffer import SampleBuffer
from station.stream.recorder.sample_times import RowTimes, StepRows, Utc
from station.stream.stream_events import EVENTS_FILE

FILTERS_FILE = "laws.csv"


FLUSH_S = 0.2
EVENT_COLUMNS = ("utc", "device_s", "sample", "event", "text")


class MonitorRecording:
    """Writes into a folder, with reference time alongside the rows where ``utc`` reports it.

    ``name`` is the file being written, empty while none is.
    """

    def __init__(self, folder: Path, wire: WireFormat, utc: Utc | None = None) -> None:
        self._folder, self._wire, self._times = folder, wire, RowTimes(utc)
        self._writer: StepWriter | None = None
        self._pace, self._begin = FlushInterval(FLUSH_S), -1
        self.name = ""

    def begin(self) -> str:
        """Begin a file and return its name."""
        path = free_path(self._folder, "recording")
        self._writer, self.name = StepWriter(path, BY_OUTPUT[self._wire.output]), path.name
        self._rows = StepRows(self._writer, self._times, self._wire.pulse)
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
            self._times.reset()
        try:
            for chunk, block in buffer.recording([(first, last)]):
                self._rows.write(chunk, block, kind.triads)
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
        return name

    def take_filters(self, view: MonitorView) -> None:
        """Write what the filters read, if a file is open; raise `CannotWrite` if the disk refuses."""
        if not self.name or not view.filters or view.reading is None:
            return
        columns: dict[str, float] = {"t_s": view.reading.t, "sample": view.reading.sample}
        for one in view.filters:
            columns |= {f"{one.name}_roll_deg": one.roll, f"{one.name}_pitch_deg": one.pitch}
        if (apart := difference(view.filters)) is not None:
            columns |= {f"difference_{name}_deg": value for name, value in apart._asdict().items()}
        add_rows(self._folder / FILTERS_FILE, columns, [map(repr, columns.values())])

    def note_late_messages(self, stream: str, read_ns: Iterable[int], counted_ns: int) -> None:
        """Write what counts in a later tick than it was read in; raise `CannotWrite` if the disk refuses."""
        note_late_messages(self._folder, stream, read_ns, counted_ns)

    def note(self, event: str, text: str, device_s: float, sample: int) -> None:
        """Write what happened; raise `CannotWrite` if the disk refuses."""
        row = datetime.now(UTC).isoformat(), f"{device_s:.6f}", sample, event, text
        add_rows(self._folder / EVENTS_FILE, EVENT_COLUMNS, [row])
