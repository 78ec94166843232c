"""Every row of every table is in the journal, and whatever is changed past it is found and named."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import Table, delete, insert, select, text
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, append_only_tables, trigger_faults
from fixtures_db.database import Database
from fixtures_db.imu_models import limits_of, set_limits
from fixtures_db.journal import Head, journal_head, journalled_tables
from fixtures_db.journal_verification import missing_entry, speaks_since, verify_journal
from fixtures_db.schema import Base, ImuLimitRow, SiteRow
from fixtures_db.stored_calibrations import accept_calibration, history
from fixtures_db.verification import NO_ROW, alterations, declaration_faults
from tests.benchmarks.edited_databases.declaration_edits import REBUILT, rebuilt, unreferenced
from tests.fixtures_db.edited import free_to_write, put_back
from tests.fixtures_db.factory import facts, protect_again, solution, unprotect
from tests.fixtures_db.filled_database import JUDGED, WIDE, record
from tests.paths import ROOT

ROW_TITLE = {table.__tablename__: title for table, title in ROW_TITLES.items()}


def found(db: Database, *statements: str) -> list[str]:
    """Return what is found after some statements of whoever may write to the file; triggers are put back."""
    with db.write() as session:
        protected = append_only_tables()
        for table in protected:
            unprotect(session, table)
        for statement in statements:
            session.execute(text(statement))
        for table in protected:
            protect_again(session, table)
    with db.read() as session:
        return [str(fault) for fault in alterations(session)]


def test_what_the_station_writes_is_the_sum_of_the_journal(filled: Database) -> None:
    with filled.read() as session:
        assert alterations(session) == []
        begun, carried = speaks_since(session)
        assert carried == 12  # the example cube and its items, of a migration before the journal
        assert begun < begun.now(begun.tzinfo)
        tables = set(session.scalars(text("SELECT DISTINCT table_name FROM journal")))
    assert {table.name for table in journalled_tables()} == tables


@pytest.mark.parametrize(
    ("statement", "reported"),
    [
        ("UPDATE imu_limits SET high = 9 WHERE parameter LIKE '%.x'", "high 9.0, expected high 0.002"),
        ("DELETE FROM imu_limits", "imu_limits 2: found no row"),
        ("UPDATE sites SET gravity_m_s2 = 9.81", "gravity_m_s2 9.81, expected gravity_m_s2 9.80665"),
        ("UPDATE cubes SET side_mm = 401 WHERE id = 'P1'", "cubes P1: found side_mm 401.0"),
        ("DELETE FROM tolerance_items WHERE item = 't3'", "tolerance_items 3: found no row"),
        ("UPDATE campaigns SET state = 'recording'", "state recording, expected state accepted"),
        ("UPDATE campaigns SET imu_id = 2", "campaigns 1: found imu_id 2, expected imu_id 1"),
        (
            "UPDATE steps SET accepted_utc = '2026-03-04 13:00:00.000000' WHERE id = 2",
            "steps 2: found accepted_utc",
        ),
        ("INSERT INTO slabs (id) VALUES ('SLAB-9')", "slabs SLAB-9: found {"),
        ("UPDATE journal SET content = '{}' WHERE id = 20", "journal 20: found text with sha256"),
        ("DELETE FROM journal WHERE id = 20", "journal 21: found number 21, expected 20"),
        ("UPDATE journal SET event = 'insert' WHERE id = 18", "journal 18"),
    ],
)
def test_what_decides_a_pass_cannot_be_changed_past_the_journal(
    filled: Database, statement: str, reported: str
) -> None:
    assert any(reported in fault for fault in found(filled, statement))


def test_a_campaign_is_not_taken_for_another_whose_number_begins_alike(filled: Database) -> None:
    with filled.write() as session:
        for more in range(10):  # up to campaign 15
            record(session, f"more{more}", "S2")
        reported = replace(
            facts("S1"), verdict="PASS", limits=WIDE, judged=JUDGED, inputs={"again.csv": "12" * 32}
        )
        accept_calibration(session, solution(), reported, campaign_folder="c1")
    with filled.read() as session:
        assert alterations(session) == []


@pytest.mark.parametrize(
    ("statements", "reported"),
    [
        (
            ("ALTER TABLE imu_limits RENAME TO hidden", "CREATE TABLE imu_limits AS SELECT * FROM hidden",
             "INSERT INTO imu_limits SELECT id, model, parameter, low, 9.0, unit, guard_band FROM hidden",
             "DROP TABLE hidden"),
            ["imu_limits 2: found 2 rows of that key, expected one", "table imu_limits: found key none"],
        ),
        (
            ("ALTER TABLE imu_limits RENAME TO hidden", "CREATE VIEW IMU_LIMITS AS SELECT * FROM hidden"),
            ["table imu_limits: found none, expected one"],
        ),
        (("CREATE VIEW limits AS SELECT * FROM imu_limits",), ["view limits: found a view"]),
        (("DROP TABLE steps",), ["table steps: found none, expected one"]),
        ((f"UPDATE calibrations SET document = '{'[' * 100_000}' WHERE id = 1",), ["calibrations 1"]),
    ],
)  # fmt: skip
def test_tables_that_were_rebuilt_hidden_or_taken_away_are_found(
    sqlite_filled: Database, statements: tuple[str, ...], reported: list[str]
) -> None:
    faults = found(sqlite_filled, *statements)
    assert all(any(fault.startswith(one) for fault in faults) for one in reported), faults


@pytest.mark.parametrize("how", REBUILT)
def test_a_table_rebuilt_with_the_same_rows_is_found_where_it_is_declared_otherwise(
    rolled_back: Database, how: str
) -> None:
    unseen = []
    for table in unreferenced():
        with rolled_back.engine.connect() as connection:
            if rebuilt(connection, table, how) is not None and not list(declaration_faults(connection)):
                unseen.append(table.name)
    assert unseen == []


@pytest.mark.parametrize("table", [Base.metadata.tables[name] for name in ("sites", "steps", "journal")], ids=str)
def test_a_row_that_cannot_be_read_is_named_by_table_and_key(rolled_back: Database, table: Table) -> None:
    """Whatever column of it: bytes that are no text, text that is no moment, no JSON or no number."""
    with rolled_back.read() as session:
        key = session.connection().execute(select(next(iter(table.primary_key)))).scalars().all()[-1]
    [primary] = table.primary_key
    for column in table.columns:
        if column.primary_key or column.foreign_keys:
            continue
        for value in ("X'ff'", "'{'", "CAST(X'ff' AS TEXT)"):
            with rolled_back.engine.connect() as connection:
                free_to_write(connection)
                statement = f"UPDATE {table.name} SET {column.name} = {value} WHERE {primary.name} = :key"
                connection.execute(text(statement), {"key": key})
                put_back(connection)
                with Session(bind=connection) as session:
                    rows = [fault.row for fault in alterations(session)]
            reported = {f"{table.name} {key}", f"journal {key}", f"{ROW_TITLE.get(table.name)} {key}"}
            assert reported & set(rows), (column.name, value, rows)
            assert not any(row == NO_ROW for row in rows), (column.name, value, rows)


def test_a_trigger_that_is_gone_is_found(filled: Database) -> None:
    with filled.write() as session:
        unprotect(session, "journal")
    with filled.read() as session:
        faults = trigger_faults(session.connection())
    assert len(faults) == 3
    assert {fault.row.startswith("trigger journal_no_") for fault in faults} == {True}


def test_a_journal_rewritten_whole_shows_against_what_was_kept(filled: Database) -> None:
    with filled.read() as session:
        kept = journal_head(session)
        assert missing_entry(session.connection(), Head(kept.entries, kept.sha256[:16])) == []
    found(filled, f"UPDATE journal SET sha256 = '{'0' * 64}' WHERE id = {kept.entries}")
    with filled.read() as session:
        assert missing_entry(session.connection(), kept)[0].row == f"journal {kept.entries}"


def test_a_calibration_names_what_it_used_and_its_verdict_follows(filled: Database) -> None:
    with filled.read() as session:
        document = json.loads(history(session, "S1")[0].document)
        assert limits_of(session, "FOG-3") == WIDE
        assert document["journal"]["entries"] < journal_head(session).entries
    assert list(document["used"]) == ["campaign", "cube", "imu", "limits", "site", "slab"]
    with filled.write() as session:
        set_limits(session, "FOG-3", WIDE[1:])  # what came later changes nothing of that day
    with filled.read() as session:
        assert verify_journal(session) == []


@pytest.mark.parametrize("statement", [delete(ImuLimitRow), insert(SiteRow).values(id="S", latitude_deg=1.0)])
def test_statements_past_the_journal_are_refused(sqlite_db: Database, statement) -> None:
    with pytest.raises(TypeError), sqlite_db.write() as session:
        session.execute(statement)


def test_no_code_writes_rows_past_the_session() -> None:
    """`insert`, `update`, `delete` and bulk methods of SQLAlchemy stand in the journal and in migrations alone."""
    allowed = {"journal.py"}
    for path in [*(ROOT / "fixtures_db").glob("*.py"), *(ROOT / "station").rglob("*.py")]:
        if not any(word in (source := path.read_text()) for word in ("sqlalchemy", "bulk_")):
            continue
        tree = ast.parse(source)
        names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
                 and (node.module or "").startswith("sqlalchemy") for alias in node.names}  # fmt: skip
        called = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        bulk = {"bulk_save_objects", "bulk_insert_mappings", "bulk_update_mappings"} & called
        assert path.name in allowed or not ({"insert", "update", "delete"} & names or bulk), Path(path)


def test_every_table_is_journalled_but_the_journal() -> None:
    assert {table.name for table in journalled_tables()} == Base.metadata.tables.keys() - {"journal"}
