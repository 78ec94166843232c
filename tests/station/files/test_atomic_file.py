"""On a disk that takes long for a flush the time is not spent on flushing alone."""

import errno
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from fixtures_db.database import open_db
from fixtures_db.errors import NotWritten
from fixtures_db.folder_on_disk import make_folder
from procedures.errors import ErrorCode
from station.errors import CannotWrite, DiskFails, exit_code
from station.files.atomic_file import FlushInterval, replace_file, write_file_pair
from station.files.calibrated_sample_writers import Ros2Samples, SampleColumns
from station.files.mcap_files import StepWriter
from tests.benchmarks import failing_disks
from tests.benchmarks.power_cuts.trial import tried
from tests.refusals import refused


def test_what_takes_long_is_done_no_more_than_half_of_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    pace, flushes = FlushInterval(0.2), 0
    for _ in range(12_000):  # a piece of 10 ms each
        now[0] += 0.01
        if pace.is_due:
            flushes += 1
            with pace.flushing():
                now[0] += 10.0
    assert flushes * 10.0 <= now[0] / 2 + 10.0
    assert flushes >= 10


JOBS, FAULTS = 3, 5


needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")


@needs_compiler
@pytest.mark.parametrize("every", [401, pytest.param(5, marks=pytest.mark.proof)])
def test_wherever_the_disk_fails_nothing_accepted_is_lost_and_a_line_says_it(every: int) -> None:
    rows = failing_disks.tried("--every", str(every))
    assert not [row for row in rows if row["wrong"]]
    assert len(rows) == JOBS * FAULTS
    assert all(row["calls"] >= 1 for row in rows)  # each fault came


@needs_compiler
@pytest.mark.proof
def test_on_a_slow_disk_nothing_is_lost_and_no_sample_lacks() -> None:
    rows = failing_disks.tried("--slow", "0.03", "--jobs", "accept", "record")
    assert rows == [{"job": "accept", "wrong": {}}, {"job": "record", "wrong": {}}]


def test_a_failed_fsync_is_no_success(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(os, "fsync", fails)
    with refused(DiskFails, ErrorCode.DISK_FAILS):
        replace_file(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_text() == "old"
    assert exit_code(DiskFails("a", "x")) == exit_code(CannotWrite("a", "x")) == 2


def test_a_database_on_a_disk_that_fails_is_not_taken_for_another_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sqlite3

    from sqlalchemy.exc import OperationalError

    def fails(*_: object) -> None:
        raise OperationalError("", {}, sqlite3.OperationalError("disk I/O error"))

    monkeypatch.setattr("fixtures_db.database._upgrade", fails)
    with refused(NotWritten, ErrorCode.DATABASE):
        open_db(tmp_path / "station.db")
    assert exit_code(NotWritten("x", "full")) == 2


LEAST_KINDS = {"campaign": 12, "recording": 50, "fixtures": 8}
Synced = Callable[[], list[str]]


@pytest.mark.parametrize("number", [20, pytest.param(400, marks=pytest.mark.proof)])
@pytest.mark.parametrize("workload", LEAST_KINDS)
def test_after_a_power_cut_nothing_that_was_reported_is_lost(workload: str, number: int) -> None:
    if shutil.which("strace") is None:
        pytest.skip("no strace here")
    trial = tried(workload, number, seed=1)
    assert not trial.wrong, trial.first
    assert trial.states >= min(number, LEAST_KINDS[workload])  # a short workload leaves no more states than that
    assert trial.kinds >= (LEAST_KINDS[workload] if number >= 80 else 2)


@pytest.fixture
def did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Synced:
    """Return what was synced and renamed, in order, by its path in ``tmp_path``."""
    seen = list[str]()

    def noting(name: str) -> None:
        real = getattr(os, name)

        def call(what: int | Path, *more: Path) -> None:
            path = os.readlink(f"/proc/self/fd/{what}") if isinstance(what, int) else more[0]
            seen.append(f"{name} {os.path.relpath(path, tmp_path)}")
            real(what, *more)

        monkeypatch.setattr(os, name, call)

    noting("fsync")
    noting("replace")
    return lambda: seen


def test_a_folder_is_on_the_disk_with_all_that_were_made_above_it(tmp_path: Path, did: Synced) -> None:
    make_folder(tmp_path / "a" / "b" / "c")
    assert did() == ["fsync a/b", "fsync a", "fsync ."]
    make_folder(tmp_path / "a" / "b" / "c")
    assert len(did()) == 3


def test_a_recording_has_its_name_from_its_first_sync_on(tmp_path: Path, did: Synced) -> None:
    writer = StepWriter(tmp_path / "r.mcap")
    writer.flush()
    writer.flush()
    writer.close()
    # as it closes, once for the data and once for the end that says that they are whole
    assert did() == ["fsync r.mcap", "fsync .", *3 * ["fsync r.mcap"]]


def test_the_companion_of_a_file_is_gone_before_the_file_is_replaced(tmp_path: Path, did: Synced) -> None:
    for name in ("out.csv", "out.json"):
        (tmp_path / name).write_text("old")
    with write_file_pair(tmp_path / "out.csv", tmp_path / "out.json") as places:
        for place in places:
            place.write_text("new")
    assert did()[-5:] == ["fsync .", "replace out.csv", "fsync .", "replace out.json", "fsync ."]


def test_a_bag_is_on_the_disk_with_the_names_of_its_files(tmp_path: Path, did: Synced) -> None:
    pytest.importorskip("rosbags")
    Ros2Samples(tmp_path / "bag", SampleColumns(("t_s", *"abcdef"), 0, "sensor", is_si=True)).finish()
    assert did()[-1] == "fsync bag"
