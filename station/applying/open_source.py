"""Open what the command line names as a source of samples: a campaign's folder, a recording or a log."""

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from procedures.frames import TRIADS
from station.applying.log_source import LogSource, step_source
from station.applying.recording_source import RawSource, RecordingSource
from station.applying.source import Samples, Source, Stated
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.logs.log_columns import ColumnOptions
from station.files.mcap_files.reader import sample_messages, topic_messages
from station.files.mcap_files.schemas import RAW_TOPIC
from station.files.opening import open_inside, unreadable

STEP_KINDS = ("dwell", "turn", "move", "sequence", "soak", "monitor")  # all but a rate table, which has no samples


@dataclass(frozen=True, slots=True, eq=False)
class CampaignSource:
    """The steps of a campaign; files of a rate table are left out."""

    steps: tuple[Source, ...]
    stated: Stated

    @classmethod
    def open(cls, folder: Path) -> "CampaignSource":
        """Open a campaign's folder; raises `DataRefused` where it or one of its files breaks a rule."""
        tables, _, _ = read_campaign_toml(folder)
        imu = tables.imu
        mounting = ",".join(tables.fixture.imu_axes) if tables.fixture is not None else None
        stated = Stated(
            str(folder), imu.model, imu.serial, imu.output, imu.wrap_bits, period=imu.sample_period_s,
            mounting=mounting, rates_in=imu.unit_gyro or imu.unit_accel or "",
        )  # fmt: skip
        names = [table.file for kind in STEP_KINDS for table in getattr(tables, kind)]
        opened = [_step(folder, name, stated) for name in names]
        if not opened:
            raise DataRefused(folder / CAMPAIGN_TOML, None, "no step", f"at least one of {', '.join(STEP_KINDS)}")
        begins = [_begin(step) for step in opened]
        steps = tuple(opened[i] for i in sorted(range(len(opened)), key=begins.__getitem__))
        channels = tuple(dict.fromkeys(name for step in steps for name in step.stated.auxiliary))
        triads = tuple(name for name in TRIADS if any(name in step.stated.triads for step in steps))
        warm = any(step.stated.temperature for step in steps)
        there = [step.stated.accelerometers for step in steps if any(step.stated.accelerometers)] or [(True,) * 3]
        axes = tuple(all(each) for each in zip(*there, strict=True))
        return cls(
            steps, replace(stated, temperature=warm, auxiliary=channels, triads=triads, accelerometers=axes)
        )

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for i, step in enumerate(self.steps):
            for block in step.blocks():
                yield replace(block, done=(i + block.done) / len(self.steps))


def _begin(step: Source) -> float:
    with closing(step.blocks()) as blocks:
        return float(next(blocks).t[0])


def _step(folder: Path, name: str, stated: Stated) -> LogSource | RecordingSource:
    with open_inside(folder, name, folder / CAMPAIGN_TOML, None):
        pass
    return (
        RecordingSource.open(folder / name, stated)
        if name.endswith(".mcap")
        else step_source(folder / name, stated)
    )


RECORDING = "recording.mcap"
KEPT = "session_*.mcap"  # of `station stream --folder`


def open_source(path: Path, columns: ColumnOptions, serial: str | None) -> Source:
    """Open a campaign's folder, one of `station record` or `station stream`, an MCAP file or a log.

    ``columns`` is what was stated of a log, ``serial`` the unit's serial number where the recording has none.
    Raise `DataRefused` if it is none of them.
    """
    if path.is_dir():
        if (path / CAMPAIGN_TOML).is_file():
            return CampaignSource.open(path)
        path = _recording_in(path)
    if path.suffix.lower() == ".mcap":
        stated = Stated(str(path), serial=serial)
        return RawSource.open(path, stated) if _is_of_bytes(path) else RecordingSource.open(path, stated)
    found = LogSource.open(path, columns)
    return replace(found, stated=replace(found.stated, serial=serial))


def _recording_in(folder: Path) -> Path:
    """Return the recording in a folder, or the bytes that `station stream` kept in it."""
    if (folder / RECORDING).is_file():
        return folder / RECORDING
    kept = sorted(folder.glob(KEPT))
    if len(kept) != 1:
        found = f"{len(kept)} files {KEPT}" if kept else "neither a campaign nor a recording"
        expected = f"a folder with {CAMPAIGN_TOML}, {RECORDING} or one {KEPT}"
        raise DataRefused(folder, None, found, expected, "name a file of it")
    return kept[0]


def _is_of_bytes(file: Path) -> bool:
    """Say whether an MCAP file holds bytes of a device and no samples."""
    try:
        with closing(sample_messages(file)) as samples, closing(topic_messages(file, {RAW_TOPIC: bytes})) as raw:
            return next(samples, None) is None and next(raw, None) is not None
    except OSError as error:
        raise unreadable(file, error) from None
