"""A row as the journal writes it: its table, its key and one text of its columns, read from the database itself.

What was written is read back, so that the text is that of what is stored: a number as the column keeps it, a
moment in UTC. A column without a value is left out: one that a later station adds changes no text.
"""

import json
from collections.abc import Iterator, Sequence
from datetime import date
from typing import Any

from sqlalchemy import JSON, Column, ColumnElement, Connection, Table, Text, inspect, select, tuple_
from sqlalchemy.exc import SQLAlchemyError

from fixtures_db.hash_chain import canonical, digest
from fixtures_db.schema import Base, JournalRow

UNREADABLE = (  # bytes that are no text, text that is no date or JSON, JSON of another shape
    SQLAlchemyError,
    ValueError,
    TypeError,
    AttributeError,
    LookupError,
    RecursionError,
)


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
    said = zip(columns, values, strict=True)
    return canonical({column.key: _written(column, value) for column, value in said if value is not None})


def _written(column: Column[Any], value: Any) -> Any:
    if isinstance(column.type, JSON):
        return f"sha256 {digest(canonical(value))}"
    if isinstance(column.type, Text):
        return f"sha256 {digest(value)}"
    return value.isoformat() if isinstance(value, date) else value
