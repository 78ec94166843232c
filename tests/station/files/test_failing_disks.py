"""Whatever the disk answers, what was accepted stays, and one line says what is wrong and what to do."""

import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fixtures_db.database import open_db
from fixtures_db.errors import NotWritten
from station.errors import CannotWrite, DiskFails
from station.exit_codes import exit_code
from station.files.atomic_file import replace_file
from tests.paths import ROOT
from tests.patience import HANG_S

JOBS, FAULTS = 3, 5


@pytest.fixture(scope="module")
def slow_disk() -> Iterator[subprocess.Popen[str]]:
    """Programs on a slow disk, begun before the first test: they wait for most of their time."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc here")
    asked = ["--slow", "0.03", "--jobs", "accept", "record"]
    command = [sys.executable, "-m", "tests.benchmarks.failing_disks", *asked]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as running:
        yield running
        running.kill()  # where nobody asked what it says


@pytest.mark.usefixtures("slow_disk")
def test_wherever_the_disk_fails_nothing_accepted_is_lost_and_a_line_says_it() -> None:
    command = [sys.executable, "-m", "tests.benchmarks.failing_disks", "--every", "11"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    rows = [line.split() for line in done.stdout.splitlines()[1:]]
    assert "WRONG" not in done.stdout, done.stdout
    assert len(rows) == JOBS * FAULTS, done.stdout
    assert all(int(row[-3]) >= 1 for row in rows)  # each fault came


def test_on_a_slow_disk_nothing_is_lost_and_no_sample_lacks(slow_disk: subprocess.Popen[str]) -> None:
    said, _ = slow_disk.communicate(timeout=HANG_S)
    rows = [line.split() for line in said.splitlines()[1:]]
    assert [(row[0], row[-1]) for row in rows] == [("accept", "0"), ("record", "0")], said
    assert slow_disk.returncode == 0


def test_a_failed_fsync_is_no_success(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    (tmp_path / "a").write_text("old")
    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(
        DiskFails, match=r"a: the disk fails \(Input/output error\), expected .*copy what is there"
    ):
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
    with pytest.raises(
        NotWritten, match=r"the disk is full, over a quota or fails .*, expected .*; make room there"
    ):
        open_db(tmp_path / "station.db")
    assert exit_code(NotWritten("x", "full")) == 2
