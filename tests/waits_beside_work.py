"""Which file of tests a worker runs next: one of three begins with what waits, the others with what computes.

A test of a whole program or of a device waits for most of its time; files of such tests one after the other on one
worker leave the processors to the others. Those of the others run from both ends of the list, so that files of one
folder, which need the same modules and the same numbers, stay together.
"""

import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

WAITING = ("tests.patience", "commands.program import", "SimulatedDevice(")  # a file that waits says one of them
COMPUTING = (  # though it says so: a file whose device or program computes for two thirds of its time
    "tests/station/commands/test_can.py",
    "tests/station/monitor/test_locating_by_camera.py",
    "tests/station/monitor/test_locating_by_wheel.py",
    "tests/station/monitor/test_locator_thread.py",
    "tests/station/sending/test_foxglove.py",
    "tests/station/stream/gnss/test_clock_found.py",
)
LONGEST = (  # these first, so that none of them is the last of all
    "tests/station/guide/test_engine.py",
    "tests/station/stream/gnss/test_every_fault.py",
    "tests/station/stream/reader/test_every_fault.py",
    "tests/station/tui/web/test_guided.py",
    "tests/station/tui/test_keystrokes.py",
    "tests/station/commands/test_live.py",
    "tests/station/commands/test_demo.py",
    "tests/station/sending/test_stream_program.py",
    "tests/station/commands/test_site_of_a_simulated_unit.py",
    "tests/station/files/test_failing_disks.py",
    "tests/station/monitor/test_whole_program.py",
    "tests/station/commands/test_record_troubles.py",
    "tests/station/stream/reader/test_can_faults.py",
    "tests/drivers/can/test_can_port.py",
    "tests/station/commands/test_plain.py",
    "tests/station/commands/test_plan_guided.py",
    "tests/station/tui/test_whole_campaign.py",
    "tests/station/stream/gnss/test_campaign.py",
    "tests/station/stream/recorder/test_other_units.py",
    "tests/station/stream/gnss/test_gnss_feed.py",
    "tests/drivers/mavlink/test_link.py",
)


class WaitsBesideWork(LoadFileScheduling):
    """`--dist loadfile` with another order of files."""

    def schedule(self) -> None:
        """Leave the files in the order in which they were collected."""
        self.config.option.loadscopereorder = False
        super().schedule()

    def remove_node(self, node: WorkerController) -> str | None:
        """Leave out the files that are done: who takes the place of a dead worker would wait for ever in one."""
        self._drop_done(node)
        return super().remove_node(node)

    def _drop_done(self, node: WorkerController) -> None:
        assigned = self.assigned_work[node]
        for done in [file for file, tests in assigned.items() if all(tests.values())]:
            del assigned[done]

    def _assign_work_unit(self, node: WorkerController) -> None:
        self._drop_done(node)  # else all tests that have run are counted again behind each one
        chosen = following(list(self.workqueue), self.nodes.index(node), self.config.rootpath)
        self.workqueue.move_to_end(chosen, last=False)
        super()._assign_work_unit(node)


def following(files: Sequence[str], worker: int, root: Path) -> str:
    """Return the file that a worker, counted from 0, runs next."""
    waiting = [each for each in files if waits(each, root)]
    computing = [each for each in files if not waits(each, root)]
    if (worker % 3 == 0 and waiting) or not computing:
        return min(waiting, key=lambda each: LONGEST.index(each) if each in LONGEST else len(LONGEST))
    return computing[0 if worker % 3 < 2 else -1]


@cache
def waits(file: str, root: Path) -> bool:
    """Whether tests of a file wait for a device or a program for most of their time."""
    text = (root / file).read_text()
    return file not in COMPUTING and any(each in text for each in WAITING)


def pytest_xdist_auto_num_workers() -> int:
    """Return what ``-n auto`` is: one worker more than there are processors, because one of them waits."""
    return (os.cpu_count() or 1) + 1


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadFileScheduling | None:
    """Order the files of ``--dist loadfile``."""
    return WaitsBesideWork(config, log) if config.getvalue("dist") == "loadfile" else None
