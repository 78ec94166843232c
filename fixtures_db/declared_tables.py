"""Whether each table is declared as the station makes it: one built anew may hold the same and refuse less."""

import re
import warnings
from collections.abc import Iterator
from typing import Any

from sqlalchemy import (
    Column,
    Connection,
    Dialect,
    ForeignKeyConstraint,
    Inspector,
    Table,
    UniqueConstraint,
    inspect,
)
from sqlalchemy import text as sql
from sqlalchemy.exc import SAWarning
from sqlalchemy.types import NullType

from fixtures_db.hash_chain import ChainFault
from fixtures_db.migrations import HEAD
from fixtures_db.schema import Base

Declared = dict[str, str]  # of a table: "column id", "key", "reference imu_id", ... as text
# what of a declaration of SQLite no inspector tells; the station uses none of it
_UNTOLD = re.compile(r"\b(AUTOINCREMENT|CHECK|COLLATE|CONFLICT|DEFAULT|DEFERR\w+|STRICT|VIRTUAL|WITHOUT)\b", re.I)
_DECLARED = sql("SELECT type, name, tbl_name, sql FROM sqlite_master WHERE sql IS NOT NULL")
_FAULTLESS = set[tuple[tuple[str, ...], ...]]()  # what SQLite said of tables that were found as made


def declaration_faults(connection: Connection) -> list[ChainFault]:
    """Return what of each table is declared otherwise; the order of columns and constraints' names have no say."""
    if connection.dialect.name != "sqlite":
        return list(_declared_otherwise(connection))
    declared = tuple(map(tuple, connection.execute(_DECLARED)))
    if declared in _FAULTLESS:
        return []
    if not (found := [*_declared_otherwise(connection), *_untold(declared)]):
        _FAULTLESS.add(declared)
    return found


def _declared_otherwise(connection: Connection) -> Iterator[ChainFault]:
    known = inspect(connection)
    for name, table in Base.metadata.tables.items():
        found, expected = _as_found(known, name, connection.dialect), _as_made(table, connection.dialect)
        for what in sorted(found.keys() | expected.keys()):
            if (now := found.get(what)) != (made := expected.get(what)):
                yield ChainFault(f"table {name}", f"{what} {now or 'none'}", f"{what} {made or 'none'}")


def version_faults(connection: Connection) -> Iterator[ChainFault]:
    """Yield what is wrong with the schema version, of which there is one."""
    if not inspect(connection).has_table("alembic_version"):
        yield ChainFault("alembic_version", "no table", f"version {HEAD}")
        return
    there = sorted(map(str, connection.execute(sql("SELECT version_num FROM alembic_version")).scalars()))
    if there != [HEAD]:
        yield ChainFault("alembic_version", f"version {', '.join(there) or 'none'}", f"version {HEAD}")


def _as_made(table: Table, dialect: Dialect) -> Declared:
    made = {f"column {one.name}": _column(one, dialect) for one in table.columns}
    made["key"] = ", ".join(one.name for one in table.primary_key)
    for each in table.constraints:
        match each:
            case UniqueConstraint():
                made[f"unique {_names(each.columns.keys())}"] = "yes"
            case ForeignKeyConstraint():
                to = ", ".join(one.column.name for one in each.elements)
                made[f"reference {_names(each.columns.keys())}"] = f"{each.referred_table.name} ({to})"
    for index in table.indexes:
        made[f"index {index.name}"] = _names(index.columns.keys())
    return made


def _as_found(known: Inspector, name: str, dialect: Dialect) -> Declared:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SAWarning)  # of an index by an expression: `_untold` names it
        columns, indices = known.get_columns(name), known.get_indexes(name)
    found = {f"column {one['name']}": _found_column(one, dialect) for one in columns}
    found["key"] = ", ".join(known.get_pk_constraint(name)["constrained_columns"])
    for unique in known.get_unique_constraints(name):
        found[f"unique {_names(unique['column_names'])}"] = f"yes{_options(unique.get('dialect_options'))}"
    for key in known.get_foreign_keys(name):
        to = ", ".join(key["referred_columns"])
        said = f"{key['referred_table']} ({to}){_options(key.get('options'))}"
        found[f"reference {_names(key['constrained_columns'])}"] = said
    for index in indices:
        if not index.get("duplicates_constraint"):
            unique_too = " UNIQUE" if index["unique"] else ""
            on = _names([str(one) for one in index["column_names"]])
            found[f"index {index['name']}"] = f"{on}{unique_too}{_options(index.get('dialect_options'))}"
    return found | {f"check {one['name']}": one["sqltext"] for one in known.get_check_constraints(name)}


def _column(column: Column[Any], dialect: Dialect) -> str:
    counts = dialect.name == "postgresql" and column is column.table.autoincrement_column
    return _said(column.type.compile(dialect), bool(column.nullable), "counted" if counts else None)


def _found_column(found: Any, dialect: Dialect) -> str:
    default = found["default"]
    if default is not None and found.get("autoincrement") is True:
        default = "counted"
    others = _options({name: found.get(name) for name in ("computed", "identity")})
    kind = "of no type" if isinstance(found["type"], NullType) else found["type"].compile(dialect)
    return _said(kind, found["nullable"], default) + others


def _said(kind: str, nullable: bool, default: str | None) -> str:
    return f"{kind}{'' if nullable else ' NOT NULL'}{'' if default is None else f' DEFAULT {default}'}"


def _names(columns: list[str]) -> str:
    return ", ".join(sorted(columns))


def _options(said: Any) -> str:
    return "".join(f" {name} {value}" for name, value in sorted((said or {}).items()) if value)


def _untold(declared: tuple[tuple[str, ...], ...]) -> Iterator[ChainFault]:
    known = {index.name for table in Base.metadata.tables.values() for index in table.indexes}
    for kind, name, table, made in declared:
        if table not in Base.metadata.tables:
            continue
        if kind == "index" and name not in known:
            yield ChainFault(f"table {table}", f"index {name}", f"index {name} none")
        elif kind == "table" and (word := _UNTOLD.search(made)) is not None:
            yield ChainFault(f"table {table}", f"declared with {word[0]}", "declared as the station does")
