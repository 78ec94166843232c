"""Samples of a campaign's folder, step after step in the order of time."""

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from procedures.frames import TRIADS
from station.applying.log_source import LogSource, step_source
from station.applying.recording_source import RecordingSource
from station.applying.source import Samples, Source, Times, Told
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CAMPAIGN_TOML, read_campaign_toml
from station.files.opening import open_inside

STEP_KINDS = ("dwell", "turn", "move", "sequence", "soak", "monitor")  # all but a rate table, which has no samples


@dataclass(frozen=True, slots=True, eq=False)
class CampaignSource:
    """The steps of a campaign; files of a rate table are left out."""

    steps: tuple[Source, ...]
    told: Told

    @classmethod
    def open(cls, folder: Path) -> "CampaignSource":
        """Open a campaign's folder; raises `DataRefused` where it or one of its files breaks a rule."""
        tables, _, _ = read_campaign_toml(folder)
        imu = tables.imu
        mounting = ",".join(tables.fixture.imu_axes) if tables.fixture is not None else None
        said = Told(
            str(folder), imu.model, imu.serial, imu.output, imu.wrap_bits, period=imu.sample_period_s,
            mounting=mounting, rates_in=imu.unit_gyro or imu.unit_accel or "",
        )  # fmt: skip
        names = [table.file for kind in STEP_KINDS for table in getattr(tables, kind)]
        opened = [_step(folder, name, said) for name in names]
        if not opened:
            raise DataRefused(folder / CAMPAIGN_TOML, None, "no step", f"at least one of {', '.join(STEP_KINDS)}")
        begins = [_begin(step) for step in opened]
        steps = tuple(opened[i] for i in sorted(range(len(opened)), key=begins.__getitem__))
        channels = tuple(dict.fromkeys(name for step in steps for name in step.told.auxiliary))
        triads = tuple(name for name in TRIADS if any(name in step.told.triads for step in steps))
        warm = any(step.told.temperature for step in steps)
        there = [step.told.accelerometers for step in steps if any(step.told.accelerometers)] or [(True,) * 3]
        axes = tuple(all(each) for each in zip(*there, strict=True))
        return cls(steps, replace(said, temperature=warm, auxiliary=channels, triads=triads, accelerometers=axes))

    def times(self) -> Generator[Times]:
        """Yield the times (n,) [s] of all samples, as `Source`."""
        for step in self.steps:
            yield from step.times()

    def blocks(self) -> Generator[Samples]:
        """Yield all samples, as `Source`."""
        for i, step in enumerate(self.steps):
            for block in step.blocks():
                yield replace(block, done=(i + block.done) / len(self.steps))


def _begin(step: Source) -> float:
    with closing(step.times()) as times:
        return float(next(times)[0][0])


def _step(folder: Path, name: str, said: Told) -> LogSource | RecordingSource:
    with open_inside(folder, name, folder / CAMPAIGN_TOML, None):
        pass
    return (
        RecordingSource.open(folder / name, said) if name.endswith(".mcap") else step_source(folder / name, said)
    )
