"""One thread of OpenBLAS a process, as `station` has it; little looking for garbage; tables that must be whole."""

import gc
import os
import shutil
import sys
import traceback
from collections import Counter
from importlib import import_module

import pytest
from hypothesis import HealthCheck, settings

from tests.paths import MEMORY
from tests.waits_beside_work import pytest_xdist_auto_num_workers, pytest_xdist_make_scheduler
from tests.worker_messages import send_what_is_seen

__all__ = ["pytest_xdist_auto_num_workers", "pytest_xdist_make_scheduler"]

# a thousand files are compiled, and their asserts rewritten, once, not by each worker and each program of each run
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before a test module loads numpy

# the folders of tests are in memory where it has room: what is tested syncs its files, and would wait for the disk
ROOM = 4e9  # bytes
if MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > ROOM and not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC:
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))

gc.disable()  # until the tests are collected: imports make many objects and drop none; who runs no tests makes few
NEW_OBJECTS = 1_000_000  # before a look for garbage among them

# an example has no deadline: on a loaded machine it would fail of slowness, which is measured in benchmarks alone
settings.register_profile("station", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("station")

TABLES = ("drivers.wire", "drivers.simulated.effects", "procedures.effects")


def pytest_configure(config: pytest.Config) -> None:
    """Say in one sentence what an entry of a table lacks: it would else be an error of every file of tests."""
    send_what_is_seen(config)
    for table in TABLES:
        try:
            import_module(table)
        except Exception as error:
            entry = traceback.extract_tb(error.__traceback__)[-1]
            raise pytest.UsageError(f"{entry.filename}, line {entry.lineno}: {error}") from error


def pytest_collection_finish() -> None:
    """Look for garbage among what the tests make, not over and over among the modules and the tests themselves."""
    gc.freeze()
    gc.set_threshold(NEW_OBJECTS)
    gc.enable()


def pytest_runtest_logfinish() -> None:
    """After a test in which Python looked for garbage, freeze what is left, so that later looks skip it.

    Looks over and over were a twentieth of all processor time. Only between tests: a library that looks itself,
    and then asks who holds an object, is told of no frozen one.
    """
    looks = sum(gc.get_count()[1:])
    if looks:
        gc.collect()  # what is frozen as garbage is never freed
        gc.freeze()


def pytest_unconfigure() -> None:
    """Look among the last objects for files left open in garbage; pytest's five looks then find all frozen."""
    gc.collect()
    gc.freeze()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say as the last words what this machine could not test, and how many tests that were."""
    reasons = Counter(str(each.longrepr[-1]).removeprefix("Skipped: ") for each in _skipped(terminalreporter))
    if reasons:
        terminalreporter.section(f"NOT TESTED HERE: {reasons.total()} tests", sep="-")
        for reason, count in reasons.most_common():
            terminalreporter.write_line(f"{count:5d}  {reason}")


def _skipped(terminalreporter: pytest.TerminalReporter) -> list[pytest.TestReport]:
    return [each for each in terminalreporter.stats.get("skipped", []) if isinstance(each.longrepr, tuple)]
