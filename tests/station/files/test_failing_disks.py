"""Whatever the disk answers, what was accepted stays, and one line says what is wrong and what to do."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fixtures_db.database import open_db
from fixtures_db.errors import NotWritten
from procedures.error_codes import ErrorCode
from station.errors import CannotWrite, DiskFails
from station.exit_codes import exit_code
from station.files.atomic_file import replace_file
from tests.paths import ROOT
from tests.refusals import refused

JOBS, FAULTS = 3, 5


needs_compiler = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here")


@needs_compiler
@pytest.mark.parametrize("every", [101, pytest.param(5, marks=pytest.mark.proof)])
def test_wherever_the_disk_fails_nothing_accepted_is_lost_and_a_line_says_it(every: int) -> None:
    command = [sys.executable, "-m", "tests.benchmarks.failing_disks", "--every", str(every)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert "WRONG" not in done.stdout, done.stdout
    assert len(rows) == JOBS * FAULTS, done.stdout
    assert all(int(row[-3]) >= 1 for row in rows)  # each fault came


@needs_compiler
@pytest.mark.proof
def test_on_a_slow_disk_nothing_is_lost_and_no_sample_lacks() -> None:
    asked = ["--slow", "0.03", "--jobs", "accept", "record"]
    command = [sys.executable, "-m", "tests.benchmarks.failing_disks", *asked]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert [(row[0], row[-1]) for row in rows] == [("accept", "0"), ("record", "0")], done.stdout


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
