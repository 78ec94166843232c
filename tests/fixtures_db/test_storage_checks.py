"""Forms that nobody wrote, references to nothing, pages and settings that are not as made: each is named."""

from pathlib import Path

import pytest
from sqlalchemy import text

from fixtures_db.database import Database, open_db
from fixtures_db.hash_chain import ChainFault
from fixtures_db.verification import declaration_faults, verify_storage
from tests.fixtures_db.edited import edited, put_back


@pytest.mark.parametrize(
    ("statement", "row", "found", "expected"),
    [
        ("UPDATE steps SET superseded = 2 WHERE id = 3", "steps 3", "superseded stored as 2", "1"),
        (
            "UPDATE slab_levels SET due_date = '2027-03-04 00:00:00' WHERE id = 2",
            "slab_levels 2", "due_date stored as '2027-03-04 00:00:00'", "'a value of type Date()'",
        ),
        (
            "UPDATE campaigns SET started_utc = '2026-03-04' WHERE id = 1",
            "campaigns 1", "started_utc stored as '2026-03-04'", "'2026-03-04 00:00:00.000000'",
        ),
        (
            "UPDATE slabs SET due_date = 'soon' WHERE id = 'SLAB-1'",
            "slabs SLAB-1", "due_date stored as 'soon'", "'a value of type Date()'",
        ),
        (
            "UPDATE calibrations SET imu_id = 99 WHERE id = 2",
            "calibrations 2", "a row of imus that is not there", "one that is",
        ),
        ("ALTER TABLE imus ADD COLUMN colour TEXT", "table imus", "column colour TEXT", "column colour none"),
        ("CREATE VIEW limits AS SELECT * FROM steps", "view limits", "a view", "none: the station makes none"),
    ],
)  # fmt: skip
def test_what_is_stored_otherwise_is_named_with_what_is_expected(
    rolled_back: Database, statement: str, row: str, found: str, expected: str
) -> None:
    with edited(rolled_back, statement) as session:
        put_back(session.connection())
        [fault] = verify_storage(session)
        assert fault == ChainFault(row, found, expected)


def test_an_index_that_lacks_rows_is_reported_of_the_file_three_times_at_most(sqlite_filled: Database) -> None:
    with sqlite_filled.engine.begin() as connection:
        other = "replace(sql, '(campaign_id)', '(name)')"
        connection.execute(text("PRAGMA writable_schema = ON"))
        connection.execute(text(f"UPDATE sqlite_master SET sql = {other} WHERE type = 'index'"))
        connection.execute(text("PRAGMA writable_schema = RESET"))
    with sqlite_filled.read() as session:
        faults = [fault for fault in verify_storage(session) if fault.row == "database file"]
    assert [fault.expected for fault in faults] == ["a whole one"] * 3
    assert all("missing from index" in fault.found for fault in faults)


def test_a_table_declared_otherwise_after_a_check_is_found_by_the_next(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        for _ in "ab":
            with database.read() as session:
                assert declaration_faults(session.connection()) == []
        with database.engine.begin() as connection:
            connection.execute(text("ALTER TABLE imus ADD COLUMN colour TEXT"))
        with database.read() as session:
            [fault] = declaration_faults(session.connection())
    assert (fault.row, fault.expected) == ("table imus", "column colour none")
