"""A plain recording: what a device sends for so many seconds, bytes and counts, with no step to it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import ReplayEnded
from station.errors import CannotWrite, cannot_write
from station.files.atomic_file import FlushInterval
from station.files.mcap_files import BY_OUTPUT, StepWriter
from station.files.sha256sums import append_hash
from station.stream.live.live_feed import LiveFeed
from station.stream.recorder.sample_times import RowTimes, StepRows

if TYPE_CHECKING:
    from station.stream.gnss_feed import GnssFeed

RECORDING_FILE = "recording.mcap"
FLUSH_S = 0.2


@dataclass(frozen=True, slots=True)
class FinishedRecording:
    """A finished recording and its length [s of device time]."""

    path: Path
    samples: int
    seconds: float


def record(
    feed: LiveFeed,
    folder: Path,
    seconds: float,
    gnss: "GnssFeed | None" = None,
    look: Callable[[], None] = lambda: None,
) -> FinishedRecording:
    """Record ``seconds`` of samples (lost ones not counted) into a folder; what was flushed survives a kill.

    With ``gnss``, rows hold reference time too (``utc_s``). ``look`` is called often, also while nothing comes.

    Raises
    ------
    DriverError
        What the stream refuses, `ReplayEnded` if a replayed file holds no sample; the file is finished first.
    CannotWrite
        If the disk refuses; what it took stays.
    """
    decoder, times = feed.stream.decoder, RowTimes(gnss.utc if gnss else None)
    writer, pace = StepWriter(folder / RECORDING_FILE, BY_OUTPUT[decoder.wire.output]), FlushInterval(FLUSH_S)
    period, samples, rows = 0.0, 0, StepRows(writer, times, decoder.wire.pulse)

    def advance() -> None:
        if gnss is not None:
            gnss.advance()
        look()

    with _the_disk_refusing(writer.path):
        try:
            for piece in feed.pieces(advance):
                if piece.restart_at is not None:
                    times.reset()
                rows.write(piece.chunk, piece.block, decoder.kind.triads)
                samples += len(piece.block)
                if pace.is_due:
                    with pace.flushing():
                        writer.flush()
                period = feed.stream.period or 0.0
                if period and samples * period >= seconds:
                    break
        except ReplayEnded:
            if not samples:
                raise
        finally:
            append_hash(folder, RECORDING_FILE, writer.close())
    return FinishedRecording(writer.path, samples, samples * period)


@contextmanager
def _the_disk_refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except (CannotWrite, ConnectionError, TimeoutError):  # reported already, or the device's
        raise
    except OSError as error:
        raise cannot_write(path, error) from error
