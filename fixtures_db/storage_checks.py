"""Whether the database's file is whole, and holds each value in the one form in which the station writes it."""

from collections.abc import Iterator

from sqlalchemy import Connection, Table, inspect, text
from sqlalchemy.orm import Session

from fixtures_db.append_only_triggers import trigger_faults
from fixtures_db.declared_tables import declaration_faults, version_faults
from fixtures_db.hash_chain import ChainFault
from fixtures_db.row_content import UNREADABLE
from fixtures_db.schema import Base


def verify_storage(session: Session) -> list[ChainFault]:
    """Return what is wrong with triggers, tables, pages and references, and values in a form nobody wrote.

    Of PostgreSQL's pages and forms the server itself takes care.
    """
    connection = session.connection()
    found = [*trigger_faults(connection), *_views(connection), *version_faults(connection)]
    found += declaration_faults(connection)
    if connection.dialect.name == "sqlite":
        found += _damage(connection)
        for table in Base.metadata.sorted_tables:
            found += _other_forms(connection, table)
    return found


def missing_tables(connection: Connection) -> list[ChainFault]:
    """Return the tables that are not there: nothing else can be read then."""
    there = set(inspect(connection).get_table_names())
    return [ChainFault(f"table {name}", "none", "one") for name in Base.metadata.tables if name not in there]


def _views(connection: Connection) -> Iterator[ChainFault]:
    """Yield the views there are, by which a name may mean another table."""
    for name in inspect(connection).get_view_names():
        yield ChainFault(f"view {name}", "a view", "none: the station makes none")


def _damage(connection: Connection) -> Iterator[ChainFault]:
    for said in connection.execute(text("PRAGMA integrity_check(3)")).scalars():
        if said != "ok":
            yield ChainFault("database file", said, "a whole one")
    for row in connection.execute(text("PRAGMA foreign_key_check")):
        yield ChainFault(f"{row[0]} {row[1]}", f"a row of {row[2]} that is not there", "one that is")
    if (mode := connection.execute(text("PRAGMA journal_mode")).scalar()) not in {"wal", "memory"}:
        yield ChainFault("database file", f"journal mode {mode}", "wal")


def _other_forms(connection: Connection, table: Table) -> Iterator[ChainFault]:
    """Yield the values that read as they should and are stored otherwise: a flag of 2, a day as a moment."""
    columns = ", ".join(f'"{column.name}"' for column in table.columns)
    stored = connection.exec_driver_sql(f'SELECT {columns} FROM "{table.name}"').all()
    for at, column in enumerate(table.columns):
        impl = column.type.dialect_impl(connection.dialect)
        read, written = impl.result_processor(connection.dialect, None), impl.bind_processor(connection.dialect)
        for row in stored:
            try:
                value = read(row[at]) if read is not None else row[at]
                form = written(value) if written is not None and value is not None else value
            except UNREADABLE:
                form = f"a value of type {column.type!r}"
            if (type(form), form) != (type(row[at]), row[at]):
                yield ChainFault(f"{table.name} {row[0]}", f"{column.name} stored as {row[at]!r}", repr(form))
