import subprocess
import sys
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import text

from fixtures_db import database
from fixtures_db.database import Database, open_db
from fixtures_db.errors import DatabaseBusy, NewerDatabase, NotADatabase, NotWritten, SchemaAltered
from fixtures_db.fixtures import fixture_row
from fixtures_db.migrations import HEAD, KNOWN
from fixtures_db.migrations.upgrade import config
from fixtures_db.schema import Base, CubeRow
from fixtures_db.verification import alterations
from station.errors import exit_code
from tests.benchmarks.edited_databases.declaration_edits import VERSION
from tests.benchmarks.two_writers import both


def test_migrations_make_exactly_the_declared_tables(db: Database) -> None:
    with db.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []


def test_the_known_revisions_are_those_that_ship() -> None:
    scripts = ScriptDirectory.from_config(config())
    assert scripts.get_current_head() == HEAD
    assert sorted(script.revision for script in scripts.walk_revisions()) == sorted(KNOWN)


def test_the_example_cube_is_there_with_its_eleven_items(db: Database) -> None:
    with db.read() as session:
        example = fixture_row(session, CubeRow, "P1")
        assert example.side_mm == 400.0
        assert [t.item for t in example.tolerances] == "t1 t2 t3 t4-1 t4-2 t5 t6 t7 t8 t9 t10".split()
        assert {t.tolerance_mm for t in example.tolerances} == {0.04}


def test_opening_again_changes_nothing_and_needs_no_alembic(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "station.db"
    open_db(path).close()
    before = path.read_bytes()
    script = (
        "import sys; from fixtures_db.database import open_db; open_db(sys.argv[1]).close(); "
        "assert 'alembic' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script, path], check=True)
    assert path.read_bytes() == before


def test_the_connection_is_as_durable_as_promised(sqlite_db: Database) -> None:
    with sqlite_db.engine.connect() as connection:
        found = {
            name: connection.execute(text(f"PRAGMA {name}")).scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert found == {"journal_mode": "wal", "synchronous": 2, "foreign_keys": 1, "busy_timeout": 10000}


def test_a_transaction_that_fails_leaves_nothing(db: Database) -> None:
    with pytest.raises(RuntimeError, match="half-way"), db.write() as session:  # noqa: PT012
        session.execute(text("INSERT INTO slabs (id) VALUES ('S')"))
        raise RuntimeError("half-way")
    with db.read() as session:
        assert session.execute(text("SELECT count(*) FROM slabs")).scalar() == 0


def test_a_lock_that_is_kept_is_reported(db_url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database, "BUSY_TIMEOUT_S", 0.05)
    with open_db(db_url) as one, open_db(db_url) as other, one.write():
        with pytest.raises(DatabaseBusy, match=r"0\.05 s"), other.write():
            pass
        with other.read() as session:
            assert fixture_row(session, CubeRow, "P1").side_mm == 400.0


def test_a_full_disk_is_reported_and_changes_nothing(sqlite_db: Database) -> None:
    with pytest.raises(NotWritten), sqlite_db.write() as session:  # noqa: PT012
        pages = session.execute(text("PRAGMA page_count")).scalar()
        session.execute(text(f"PRAGMA max_page_count = {pages}"))
        for number in range(1000):
            session.execute(text(f"INSERT INTO slabs (id) VALUES ('{number}{'x' * 1000}')"))
    with sqlite_db.read() as session:
        assert session.execute(text("SELECT count(*) FROM slabs")).scalar() == 0


def test_a_newer_schema_is_refused_and_left_alone(sqlite_db: Database, tmp_path: Path) -> None:
    with sqlite_db.write() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(NewerDatabase, match=f"9999.*{HEAD}"):
        open_db(tmp_path / "station.db")


@pytest.mark.parametrize(
    ("statement", "reported"),
    [
        (VERSION["emptied"], "calibrations"),
        (VERSION["foreign"], "a1b2c3d4.*0001"),
        (VERSION["older"], "0007"),
        (VERSION["doubled"], f"0003, {HEAD}.*0001"),
        ("DROP TABLE alembic_version", "calibrations"),
    ],
)
def test_a_schema_version_that_is_not_that_of_the_tables_is_reported(
    db: Database, db_url: str, statement: str, reported: str
) -> None:
    with db.write() as session:
        session.execute(text(statement))
    with pytest.raises(SchemaAltered, match=reported) as error:
        open_db(db_url)
    assert exit_code(error.value) == 1
    with db.read() as session:  # a station that has it open meanwhile
        assert any(fault.row == "alembic_version" for fault in alterations(session))


def test_a_file_that_is_no_database_is_refused(tmp_path: Path) -> None:
    (tmp_path / "note.txt").write_text("this is not a database, though it is long enough to look at" * 20)
    with pytest.raises(NotADatabase, match=r"note\.txt"):
        open_db(tmp_path / "note.txt")
    for url in ("no-such-thing://x", "sqlite://host/x", "://"):
        with pytest.raises(NotADatabase):
            open_db(url)


def test_two_processes_that_write_at_once_lose_nothing(db_url: str) -> None:
    assert both(db_url, 100) == (0, [])
