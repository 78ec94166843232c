"""Every append-only table: the database refuses a change, and what is changed past it is found at its row."""

from datetime import UTC, date, datetime, timedelta
from typing import Any

import pytest
from sqlalchemy import Column, select, text
from sqlalchemy.exc import DBAPIError

from fixtures_db.append_only_rows import ROW_TITLES, append_only_tables, row_text
from fixtures_db.database import Database
from fixtures_db.schema import Base, CalibrationRow
from fixtures_db.verification import alterations, take_anchor
from tests.fixtures_db.factory import protect_again, unprotect

CHAINED = {table.__tablename__: title for table, title in ROW_TITLES.items()}
OTHERWISE = {"sqlite": "INSERT OR REPLACE INTO {0} SELECT * FROM {0}", "postgresql": "TRUNCATE {0}"}


def test_the_database_refuses_to_change_or_delete_a_row(filled: Database) -> None:
    assert set(CHAINED) <= set(append_only_tables())
    for table in append_only_tables():
        column = next(each.name for each in Base.metadata.tables[table].columns if not each.primary_key)
        otherwise = OTHERWISE[filled.engine.dialect.name].format(table)
        for statement in (f"UPDATE {table} SET {column} = {column}", f"DELETE FROM {table}", otherwise):
            with pytest.raises(DBAPIError), filled.write() as session:
                session.execute(text(statement))
    with filled.read() as session:
        assert alterations(session) == []


@pytest.mark.parametrize("table", CHAINED)
def test_a_newest_row_that_is_gone_shows_against_an_anchor_and_an_altered_one_by_itself(
    filled: Database, table: str
) -> None:
    with filled.write() as session:
        anchor = take_anchor(session)
        assert alterations(session, anchor) == []
        last = session.scalar(text(f"SELECT max(id) FROM {table}"))
        unprotect(session, table)
        session.execute(text(f"DELETE FROM {table} WHERE id = {last}"))
        protect_again(session, table)
        assert f"newest {CHAINED[table]}" in {fault.row for fault in alterations(session, anchor)}
        session.rollback()
    with filled.write() as session:
        unprotect(session, table)
        session.execute(text(f"UPDATE {table} SET previous = '{'ab' * 32}' WHERE id = {last}"))
        protect_again(session, table)
    with filled.read() as session:
        assert f"{CHAINED[table]} {last}" in {fault.row for fault in alterations(session)}


def other(column: Column[Any], value: Any) -> Any:
    """Return another value of a column."""
    if value is None:
        value = {datetime: datetime(2031, 1, 1, tzinfo=UTC), date: date(2031, 1, 1), float: 0.0, int: 0, str: ""}[
            column.type.python_type
        ]
    if isinstance(value, date):
        return value + timedelta(days=1)
    return value + (b"x" if isinstance(value, bytes) else "x" if isinstance(value, str) else 1)


@pytest.mark.parametrize(
    "table", [each for each in ROW_TITLES if each is not CalibrationRow], ids=lambda table: table.__tablename__
)
def test_the_hash_of_a_row_is_over_every_column_but_its_own(filled: Database, table: type[Any]) -> None:
    with filled.read() as session:
        row = session.scalars(select(table).order_by(table.id.desc()).limit(1)).one()
        session.expunge(row)
    for column in table.__table__.columns:
        if column.name not in {"id", "sha256"}:
            value, before = getattr(row, column.name), row_text(row)
            setattr(row, column.name, other(column, value))
            assert row_text(row) != before, column.name
            setattr(row, column.name, value)
