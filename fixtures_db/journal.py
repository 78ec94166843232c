"""One hash chain over all that ever became of any row of any table, written by the session that writes the row.

A session of `fixtures_db.database.Database.write` adds an entry for each row that a flush inserts, updates or
deletes, in the same transaction; a new table is covered unasked. Statements that change rows past the session's
unit of work are refused. `fixtures_db.journal_verification` replays the entries.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, date, datetime
from typing import Any, NamedTuple

from sqlalchemy import JSON, Column, ColumnElement, Connection, Table, Text, event, insert, inspect, select, tuple_
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import ORMExecuteState, Session, UOWTransaction

from fixtures_db.hash_chain import GENESIS, canonical, digest
from fixtures_db.schema import Base, JournalRow

UNREADABLE = (  # bytes that are no text, text that is no date or JSON, JSON of another shape
    SQLAlchemyError, ValueError, TypeError, AttributeError, LookupError, RecursionError,
)  # fmt: skip


def journalled_tables() -> tuple[Table, ...]:
    """Return every table but the journal itself, what is named standing before what names it."""
    return tuple(each for each in Base.metadata.sorted_tables if each.name != JournalRow.__tablename__)


def columns_there(connection: Connection, table: Table) -> list[Column[Any]]:
    """Return the columns of a table that the database has; one of an older schema may lack some, or all."""
    known = inspect(connection)
    if not known.has_table(table.name):
        return []
    there = {each["name"] for each in known.get_columns(table.name)}
    return [column for column in table.columns if column.name in there]


def contents(
    connection: Connection, table: Table, *which: ColumnElement[bool], columns: Sequence[Column[Any]] | None = None
) -> Iterator[tuple[str, str]]:
    """Yield key and content of a table's rows, all or those of which all of ``which`` is so, by their keys."""
    selected = list(table.columns if columns is None else columns)
    primary = [column for column in selected if column.primary_key]
    key_at = [selected.index(column) for column in primary]
    for row in connection.execute(select(*selected).where(*which).order_by(*primary)):
        yield row_key([row[at] for at in key_at]), row_content(selected, row)


def of_keys(table: Table, keys: Sequence[tuple[Any, ...]]) -> ColumnElement[bool]:
    """Return what is so of the rows of some primary keys."""
    primary = tuple(table.primary_key)
    return primary[0].in_([key[0] for key in keys]) if len(primary) == 1 else tuple_(*primary).in_(keys)


def row_key(values: Sequence[Any]) -> str:
    """Return the text of a primary key: its one value, of several a JSON list."""
    return str(values[0]) if len(values) == 1 else json.dumps(values, default=str, ensure_ascii=False)


def row_content(columns: Sequence[Column[Any]], values: Sequence[Any]) -> str:
    """Return the canonical JSON of a row by its columns' names; a long text stands as its SHA-256.

    Raises
    ------
    TypeError, ValueError
        If a column holds what its type cannot.
    """
    stated = zip(columns, values, strict=True)
    return canonical({column.key: _written(column, value) for column, value in stated if value is not None})


def _written(column: Column[Any], value: Any) -> Any:
    if isinstance(column.type, JSON):
        return f"sha256 {digest(canonical(value))}"
    if isinstance(column.type, Text):
        return f"sha256 {digest(value)}"
    return value.isoformat() if isinstance(value, date) else value


CARRY, INSERT, UPDATE, DELETE = EVENTS = ("carry", "insert", "update", "delete")
NO_CONTENT = "{}"
CODE_DIGITS = 16  # of a hash in a printed code: 2^64 tries to forge one
_CODE = re.compile(r"(?:journal )?([1-9][0-9]{0,11})-([0-9a-f]{6,64})")
_TABLE = JournalRow.metadata.tables[JournalRow.__tablename__]


class Head(NamedTuple):
    """How many entries a journal has, and the hash of the last one."""

    entries: int
    sha256: str

    @property
    def code(self) -> str:
        """The two in short, as reports and certificates print them: ``412-3a7d905cb1e6f204``."""
        return f"{self.entries}-{self.sha256[:CODE_DIGITS]}"


def read_code(text: str) -> Head | None:
    """Return the head that a printed code says, ``sha256`` its first digits; None of anything else."""
    found = _CODE.fullmatch(text)
    return None if found is None else Head(int(found[1]), found[2])


class JournalledSession(Session):
    """A session whose flushes are written to the journal."""


def entry_text(entry: Mapping[Any, Any]) -> str:
    """Return the text of an entry that is hashed: all its columns but the hash, by name."""
    stated = {column.key: entry[column.key] for column in _TABLE.columns if column.key != "sha256"}
    return canonical(stated | {"recorded_utc": stated["recorded_utc"].astimezone(UTC).isoformat()})


def journal_head(connection: Connection | Session) -> Head:
    """Return how long the journal is, and its newest hash."""
    newest = select(_TABLE.c.id, _TABLE.c.sha256).order_by(_TABLE.c.id.desc()).limit(1)
    found = connection.execute(newest).first()
    return Head(0, GENESIS) if found is None else Head(found.id, found.sha256)


def carry_over(connection: Connection) -> None:
    """Begin the journal of a database that has rows already: an entry for each, as it stands."""
    _append(connection, [(*row, CARRY, content) for row, content in _rows_now(connection).items()])


@contextmanager
def journalled(connection: Connection) -> Iterator[None]:
    """Let a migration change rows: what of any table the body changed is written to the journal at its end.

    A row that differed from its last entry before, and that the body leaves, differs from it still.
    """
    before = _rows_now(connection)
    yield
    after = _rows_now(connection)
    gone = [(*row, DELETE, NO_CONTENT) for row in reversed(before) if row not in after]
    there = [
        (*row, UPDATE if row in before else INSERT, content)
        for row, content in after.items()
        if before.get(row) != content
    ]
    _append(connection, [*gone, *there])


def _rows_now(connection: Connection) -> dict[tuple[str, str], str]:
    """Return the content of every row of every table that there is, by table and key."""
    return {
        (table.name, key): content
        for table in journalled_tables()
        if (columns := columns_there(connection, table))
        for key, content in contents(connection, table, columns=columns)
    }


@event.listens_for(JournalledSession, "after_flush")
def _record(session: Session, _flush: UOWTransaction) -> None:
    """Write what a flush changed, deletions first, each row as the database now has it."""
    changed = [row for row in session.dirty if session.is_modified(row)]
    connection = session.connection()
    events = [(table.name, row_key(key), DELETE, NO_CONTENT) for table, key in _keys(session.deleted)]
    for kind, rows in ((INSERT, session.new), (UPDATE, changed)):
        keys = dict[Table, list[tuple[Any, ...]]]()
        for table, key in _keys(rows):
            keys.setdefault(table, []).append(key)
        for table, of_table in keys.items():
            rows_now = contents(connection, table, of_keys(table, of_table))
            events += [(table.name, key, kind, content) for key, content in rows_now]
    _append(connection, events)


@event.listens_for(JournalledSession, "do_orm_execute")
def _refuse_bulk(state: ORMExecuteState) -> None:
    if state.is_insert or state.is_update or state.is_delete:
        raise TypeError("found a statement that changes rows past the journal, expected session.add or .delete")


def _keys(rows: Iterable[Any]) -> Iterable[tuple[Table, tuple[Any, ...]]]:
    for row in rows:
        mapper = inspect(row).mapper
        yield mapper.local_table, mapper.primary_key_from_instance(row)


def _append(connection: Connection, events: Iterable[tuple[str, str, str, str]]) -> None:
    """Chain entries, each a table's name, a row's key, an event and a content, to the newest one."""
    number, previous = journal_head(connection)
    now, entries = datetime.now(UTC), list[dict[str, Any]]()
    for table_name, key, kind, content in events:
        number += 1
        entry = {"id": number, "table_name": table_name, "row_key": key, "event": kind, "content": content,
                 "recorded_utc": now, "previous": previous}  # fmt: skip
        previous = digest(entry_text(entry))
        entries.append(entry | {"sha256": previous})
    if entries:
        connection.execute(insert(_TABLE), entries)
