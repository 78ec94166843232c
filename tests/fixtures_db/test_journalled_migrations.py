"""A migration that changes rows writes entries, or is caught: here, and wherever `station verify` runs."""

import ast
import re
from pathlib import Path

import pytest
from sqlalchemy import Connection, text

from fixtures_db.database import Database, open_db
from fixtures_db.journal import journalled
from fixtures_db.migrations import KNOWN
from fixtures_db.verification import alterations
from tests.benchmarks.edited_databases.honest_databases import JOURNAL_SINCE, of_version
from tests.fixtures_db.filled_database import fill
from tests.paths import ROOT

CHANGES = (
    "UPDATE sites SET height_m = 500.0",
    "INSERT INTO slabs (id) VALUES ('SLAB-9')",
    "DELETE FROM imu_limits WHERE model = 'FOG-5'",
    "UPDATE campaigns SET state = 'recorded' WHERE state = 'recording'",
)
ROWS = {"bulk_insert", "insert", "update", "delete"}


def change(connection: Connection) -> None:
    for statement in CHANGES:
        connection.execute(text(statement))


def test_a_migration_that_writes_entries_leaves_a_whole_database(db: Database) -> None:
    with db.write() as session:
        fill(session)
        before = session.scalar(text("SELECT max(id) FROM journal"))
    with db.engine.begin() as connection, journalled(connection):
        change(connection)
    with db.read() as session:
        assert alterations(session) == []
        kinds = session.execute(
            text("SELECT event, table_name FROM journal WHERE id > :before"), {"before": before}
        )
    assert {tuple(row) for row in kinds} == {
        ("update", "sites"), ("insert", "slabs"), ("delete", "imu_limits"), ("update", "campaigns")
    }  # fmt: skip


def test_a_migration_that_writes_none_is_caught(db: Database) -> None:
    with db.write() as session:
        fill(session)
    with db.engine.begin() as connection:
        change(connection)
    with db.read() as session:
        found = {fault.row.split()[0] for fault in alterations(session)}
    assert found >= {"sites", "slabs", "imu_limits", "campaigns"}


@pytest.mark.parametrize("version", [one for one in KNOWN if one >= JOURNAL_SINCE])
def test_no_migration_since_the_journal_leaves_a_fault(version: str, tmp_path: Path) -> None:
    with open_db(of_version(version, tmp_path)) as database, database.read() as session:
        assert alterations(session) == []


def unjournalled(source: str) -> bool:
    """Say whether a migration's source changes rows and names no journal."""
    tree = ast.parse(source)
    called = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    texts = [str(node.value) for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    says = any(re.match(r"\s*(INSERT|UPDATE|DELETE|REPLACE) ", one, re.I) for one in texts)
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return bool(says or called & ROWS) and not names & {"journalled", "carry_over"}


def test_a_migration_since_the_journal_that_changes_rows_names_it() -> None:
    assert unjournalled("op.execute('UPDATE sites SET height_m = 0')")
    assert unjournalled("op.bulk_insert(table, [])")
    assert not unjournalled("with journalled(op.get_bind()):\n    op.execute('UPDATE sites SET height_m = 0')")
    for path in (ROOT / "fixtures_db" / "migrations" / "versions").glob("v*.py"):
        if path.name[1:5] >= JOURNAL_SINCE:
            assert not unjournalled(path.read_text()), path.name
