"""One thread of OpenBLAS a process, as `station` has it; test folders in memory; tables that must be complete."""

import os
import shutil
import traceback
from collections import Counter
from importlib import import_module

import pytest
from hypothesis import HealthCheck, settings

from tests.paths import MEMORY

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before a test module loads numpy

# the folders of tests are in memory where it has room: what is tested syncs its files, and would wait for the disk
ROOM = 4e9  # bytes
if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > ROOM and not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))

# an example has no deadline: on a loaded machine it would fail of slowness, which is measured in benchmarks alone
settings.register_profile("station", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("station")

TABLES = ("drivers.wire", "drivers.simulated.effects", "procedures.effects")


def pytest_configure() -> None:
    """Say in one sentence what an entry of a table lacks: it would else be an error of every file of tests."""
    for table in TABLES:
        try:
            import_module(table)
        except Exception as error:
            entry = traceback.extract_tb(error.__traceback__)[-1]
            raise pytest.UsageError(f"{entry.filename}, line {entry.lineno}: {error}") from error


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say as the last words what this machine could not test, and how many tests that were."""
    reasons = Counter(str(each.longrepr[-1]).removeprefix("Skipped: ") for each in _skipped(terminalreporter))
    if reasons:
        terminalreporter.section(f"NOT TESTED HERE: {reasons.total()} tests", sep="-")
        for reason, count in reasons.most_common():
            terminalreporter.write_line(f"{count:5d}  {reason}")


def _skipped(terminalreporter: pytest.TerminalReporter) -> list[pytest.TestReport]:
    return [each for each in terminalreporter.stats.get("skipped", []) if isinstance(each.longrepr, tuple)]
