"""Whether a campaign has room on the disk: what it will write, and what is free where it goes.

A sample is written twice: its bytes into the session's journal, for as long as the port is open, and bytes and
counts into its step's file. Both are compressed, so that a sample takes about as much whatever its format; most of
it is the file's own index. The figures are the worst of all formats with 16 random bits in every channel and a
sample per read, rounded up; `tests/station/guide/test_disk_space.py` measures them again.
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from procedures.campaign.plan_steps import Step
from station.errors import DiskFull
from station.guide.campaign.checklist import step_duration

JOURNAL_BYTES = 75  # of a sample
STEP_BYTES = 135  # of a sample
WARM_UP_S = 1800.0
REPEATS_FACTOR = 1.5  # steps are done again, and people take breaks
RESULTS_BYTES = 20_000_000  # report, diagnosis, database


@dataclass(frozen=True, slots=True)
class DiskSpace:
    """Room in ``folder`` in bytes: what a campaign needs, what is free; None where it is not known."""

    folder: Path
    needed: int
    free: int | None

    @property
    def is_enough(self) -> bool:
        """Whether it is, as far as is known."""
        return self.free is None or self.free >= self.needed


def disk_needed(steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> int:
    """Return the bytes that ``steps`` will take at ``rate_hz`` samples a second, repeats and breaks included."""
    recorded_s = sum(step_duration(step) for step in steps)  # the moves between them too
    written = recorded_s * STEP_BYTES + (warm_up_s + recorded_s) * JOURNAL_BYTES
    return round(REPEATS_FACTOR * written * rate_hz) + RESULTS_BYTES


def disk_free(folder: Path) -> int | None:
    """Return the bytes that this user may still write where ``folder`` is or will be; None if not known."""
    there = folder.absolute()
    while not there.exists() and there != there.parent:
        there = there.parent
    try:
        found = os.statvfs(there)
    except OSError:
        return None
    return found.f_bavail * found.f_frsize


def disk_for(folder: Path, steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> DiskSpace:
    """Return what a campaign of ``steps`` in ``folder`` needs and has."""
    return DiskSpace(folder, disk_needed(steps, rate_hz, warm_up_s), disk_free(folder))


def refuse_full(folder: Path, steps: Sequence[Step], rate_hz: float, warm_up_s: float = WARM_UP_S) -> None:
    """Raise `DiskFull` where a campaign of ``steps`` has not enough room in ``folder``."""
    disk = disk_for(folder, steps, rate_hz, warm_up_s)
    if not disk.is_enough:
        raise DiskFull(folder, disk.needed, disk.free)
