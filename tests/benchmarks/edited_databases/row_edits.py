"""Edits of rows, for each table and column that the schema declares; each says what it did, None if it cannot."""

from collections.abc import Callable
from datetime import date, datetime, timedelta
from random import Random
from typing import Any

from sqlalchemy import Column, Connection, Table, select

from fixtures_db.schema import Base

Rows = list[dict[str, Any]]
Edit = Callable[[Connection, Table, Column, Rows, Random], str | None]
BY_COLUMN = ("change", "null", "swap")  # of a column; the others of a table, whichever column is named


def edits() -> list[tuple[str, Table, Column]]:
    """Return every kind of edit of every column of every table."""
    tables = Base.metadata.sorted_tables
    found = [(kind, table, column) for table in tables for column in table.columns for kind in BY_COLUMN]
    rows = [kind for kind in EDITS if kind not in BY_COLUMN]
    return found + [(kind, table, _key(table)) for table in tables for kind in rows]


def rows_of(connection: Connection, table: Table) -> Rows:
    """Return the rows of a table by the order of their keys."""
    return [dict(row) for row in connection.execute(select(table).order_by(_key(table))).mappings()]


def another(value: Any, column: Column, others: list[Any], chance: Random) -> Any:
    """Return another legal value of a column: one that another row has, or one near it."""
    if (there := [other for other in others if other != value]) and chance.random() < 0.5:
        return chance.choice(there)
    match value:
        case bool():
            return not value
        case int():
            return value + chance.choice((-1, 1, 2))
        case float():
            return value * (1 + chance.choice((2.0**-52, 1e-3, 1.0))) or 1e-9
        case datetime() | date():
            return value + timedelta(days=chance.choice((-1, 1, 365)))
        case dict():
            return value | {"another": "ab" * 32}
        case str() if value:
            at = chance.randrange(len(value))
            return value[:at] + ("2" if value[at] != "2" else "3") + value[at + 1 :]
    kind = column.type.python_type
    return kind(2026, 1, 1) if kind is date else kind("1") if kind in {str, int, float} else None


def change(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Give a column of a row another value."""
    row = chance.choice(rows)
    new = another(row[column.key], column, [each[column.key] for each in rows], chance)
    return _set(connection, table, row, {column.key: new}) if new != row[column.key] else None


def null(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Take a value away."""
    rows = [row for row in rows if row[column.key] is not None]
    return _set(connection, table, chance.choice(rows), {column.key: None}) if rows else None


def swap(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Exchange a value between two rows."""
    one = chance.choice(rows)
    others = [row for row in rows if row[column.key] != one[column.key]]
    if not others or column.primary_key:
        return None
    other = chance.choice(others)
    if column.unique:  # a third value between, as whoever does it by hand
        _set(connection, table, one, {column.key: "between"[: getattr(column.type, "length", None)]})
    _set(connection, table, other, {column.key: one[column.key]})
    return _set(connection, table, one, {column.key: other[column.key]})


def delete(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Delete a row."""
    row = chance.choice(rows)
    connection.execute(table.delete().where(column == row[column.key]))
    return f"{table.name} {row[column.key]} deleted"


def delete_last(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Delete some rows from the newest end."""
    for row in rows[-chance.randint(1, len(rows)) :]:
        connection.execute(table.delete().where(column == row[column.key]))
    return f"{table.name}: the newest deleted"


def duplicate(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Add a row once more under another key, with other values where one may stand once only."""
    row = chance.choice(rows)
    alone = {each.key for each in table.columns if each.unique or each.primary_key}
    alone |= {each.key for one in table.constraints if hasattr(one, "columns") and len(one.columns) > 1
              for each in one.columns if each.key not in {"model"}}  # fmt: skip
    made = {key: _new(row[key], rows, key) if key in alone and not table.c[key].foreign_keys else value
            for key, value in row.items()}  # fmt: skip
    connection.execute(table.insert().values(made))
    return f"{table.name} {row[column.key]} duplicated"


def append(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Add a row of plausible values."""
    row = chance.choice(rows)
    made = {each.key: _new(row[each.key], rows, each.key) if each.unique or each.primary_key
            else row[each.key] if each.foreign_keys
            else another(row[each.key], each, [], chance) for each in table.columns}  # fmt: skip
    connection.execute(table.insert().values(made))
    return f"{table.name}: a row appended"


def renumber(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Give a row a key that none has."""
    row = chance.choice(rows)
    return _set(connection, table, row, {column.key: _new(row[column.key], rows, column.key)})


def exchange(connection: Connection, table: Table, column: Column, rows: Rows, chance: Random) -> str | None:
    """Exchange the keys of two rows."""
    if len(rows) < 2:
        return None
    one, other = chance.sample(rows, 2)
    between = _new(one[column.key], rows, column.key)
    here, there = one[column.key], other[column.key]
    for was, now in ((here, between), (there, here), (between, there)):
        connection.execute(table.update().where(column == was).values({column.key: now}))
    return f"{table.name} {here} and {there} exchanged"


EDITS: dict[str, Edit] = {
    "change": change, "null": null, "swap": swap, "delete": delete, "delete newest": delete_last,
    "duplicate": duplicate, "append": append, "renumber": renumber, "exchange keys": exchange,
}  # fmt: skip


def make_edit(kind: str, connection: Connection, table: Table, column: Column, chance: Random) -> str | None:
    """Make an edit of `EDITS`, of a table that has rows."""
    rows = rows_of(connection, table)
    return EDITS[kind](connection, table, column, rows, chance) if rows else None


def _key(table: Table) -> Column:
    return next(iter(table.primary_key))


def _new(value: Any, rows: Rows, key: str) -> Any:
    """Return a value that no row has."""
    there = {row[key] for row in rows}
    if isinstance(value, int):
        return max(there) + 1
    text, number = str(value), 0
    while (made := f"{number:02d}{text[2:]}") in there:
        number += 1
    return made


def _set(connection: Connection, table: Table, row: dict[str, Any], values: dict[str, Any]) -> str:
    key = _key(table)
    connection.execute(table.update().where(key == row[key.key]).values(values))
    [(name, value)] = values.items()
    return f"{table.name} {row[key.key]} {name}: {str(row[name])[:60]} to {str(value)[:60]}"
