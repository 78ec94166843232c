"""Rows dropped from the newest end leave whole chains: they show against an anchor, or a hash from a report."""

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import text

from fixtures_db.append_only_rows import append_only_tables
from fixtures_db.campaigns import set_state
from fixtures_db.database import Database
from fixtures_db.journal import journal_head
from fixtures_db.stored_calibrations import accept_calibration
from station import cli
from tests.benchmarks.mutations import mutate
from tests.empty_database import empty_db
from tests.fixtures_db.factory import facts, fill_fixtures, protect_again, solution, unprotect
from tests.station.guide.recorded import accept, begin


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "station.db") as database:
        with database.write() as session:
            fill_fixtures(session)
            for bias in (1e-3, 2e-3):
                accept_calibration(session, solution(bias), facts("SIM-7"))
        recorder = begin(tmp_path / "c", database)
        accept(recorder, 1, 2)
        with database.write() as session:
            set_state(session, str(tmp_path / "c"), "recorded")
        yield database


@pytest.fixture
def verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> object:
    def run(*options: str) -> tuple[int, str]:
        code = cli.run(["verify", *options, "--db", str(tmp_path / "station.db")])
        captured = capsys.readouterr()
        return code, captured.out + captured.err

    return run


def drop(db: Database, table: str, which: str = "id = (SELECT max(id) FROM {})") -> None:
    with db.write() as session:
        unprotect(session, table)
        session.execute(text(f"DELETE FROM {table} WHERE {which.format(table)}"))
        if table in append_only_tables():
            protect_again(session, table)


@pytest.mark.parametrize("table", ["calibrations", "face_certificates", "slab_levels", "steps"])
def test_a_dropped_newest_row_shows_against_an_anchor(db, verify, tmp_path, table: str) -> None:
    anchor = str(tmp_path / "anchor.toml")
    assert verify("--write-anchor", anchor)[0] == 0
    assert verify("--anchor", anchor)[0] == 0
    drop(db, table)
    assert verify()[0] == 1
    assert verify("--anchor", anchor)[0] == 1
    assert verify("--write-anchor", anchor)[0] == 1  # an anchor never hides a loss


def test_an_older_copy_put_back_shows_against_an_anchor_or_a_code(db, verify, tmp_path) -> None:
    with sqlite3.connect(tmp_path / "station.db") as now, sqlite3.connect(tmp_path / "older.db") as older:
        now.backup(older)
    with db.write() as session:
        accept_calibration(session, solution(3e-3), facts("SIM-7"))
    with db.read() as session:
        code = journal_head(session).code
    assert verify("--write-anchor", str(tmp_path / "a"))[0] == 0
    assert verify("--head", code)[0] == 0
    db.close()
    for name in ("station.db-wal", "station.db-shm"):
        (tmp_path / name).unlink(missing_ok=True)
    (tmp_path / "older.db").rename(tmp_path / "station.db")
    assert verify()[0] == 0
    assert verify("--anchor", str(tmp_path / "a"))[0] == 1
    assert verify("--head", code)[0] == 1


def test_what_was_added_since_agrees_with_an_anchor(db, verify, tmp_path) -> None:
    verify("--write-anchor", str(tmp_path / "a"))
    with db.write() as session:
        accept_calibration(session, solution(), facts("SIM-7"))
    assert verify("--anchor", str(tmp_path / "a"))[0] == 0
    assert verify("--anchor", str(tmp_path / "a"), "--write-anchor", str(tmp_path / "a"))[0] == 0


def test_an_anchor_that_was_changed_is_refused(db, verify, tmp_path) -> None:
    verify("--write-anchor", str(tmp_path / "a"))
    content = (tmp_path / "a").read_bytes()
    (tmp_path / "a").write_bytes(content.replace(b"steps = 2", b"steps = 0"))
    assert verify("--anchor", str(tmp_path / "a"))[0] == 1
    (tmp_path / "a").write_bytes(content[: content.index(b"# sha256")])
    assert verify("--anchor", str(tmp_path / "a"))[0] == 3
    assert verify(str(tmp_path / "c"), "--anchor", str(tmp_path / "a"))[0] == 2


def test_no_mutation_is_missed(tmp_path: Path) -> None:
    outcome = mutate(tmp_path, 30, seed=3)
    assert set(outcome) <= {"found", "harmless"}, outcome
    assert outcome["found"] > 25


def test_a_stamped_anchor_says_since_when_it_witnesses(db, verify, tmp_path) -> None:
    from tests.station.results.certificate.signing.authorities import root
    from tests.station.results.certificate.signing.time_service import time_service

    kept, pem = tmp_path / "day.toml", root().pem(tmp_path, "root")
    with time_service(tmp_path / "ts") as service:
        code, reported = verify("--write-anchor", str(kept), "--stamp", service)
    assert code == 0
    assert verify("--anchor", str(kept))[0] == 0
    with db.write() as session:
        accept_calibration(session, solution(), facts("SIM-7"))
    code, reported = verify("--anchor", str(kept), "--trust", str(pem))
    assert (code, "1 change since" in reported) == (0, True), reported
    stamp = kept.with_name("day.toml.tsr")
    verify("--write-anchor", str(tmp_path / "b"))
    (tmp_path / "b.tsr").write_bytes(stamp.read_bytes())  # the stamp of another
    assert verify("--anchor", str(tmp_path / "b"))[0] == 1
    assert verify("--write-anchor", str(kept))[0] == 0
    assert not stamp.exists()
    code, reported = verify("--write-anchor", str(kept), "--stamp", "http://127.0.0.1:9/")
    assert (code, kept.exists()) == (4, True), reported


def test_an_anchor_without_a_journal_is_read(db, verify, tmp_path) -> None:
    verify("--write-anchor", str(tmp_path / "a"))
    from station.files.database_files import seal_of, sealed

    content = seal_of(tmp_path / "a")[0].decode()
    lines = [line for line in content.splitlines() if not line.startswith(("journal", "entries"))]
    (tmp_path / "a").write_text(sealed("\n".join(lines) + "\n"))
    assert verify("--anchor", str(tmp_path / "a"))[0] == 0
    drop(db, "calibrations")
    assert verify("--anchor", str(tmp_path / "a"))[0] == 1
