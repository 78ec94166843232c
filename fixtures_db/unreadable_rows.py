"""Which row of a database cannot be read: tables are read whole, and row by row where one cannot be."""

import json
from typing import Any

from sqlalchemy import ColumnElement, Connection, Table, select, text
from sqlalchemy.orm import Session

from fixtures_db.row_content import UNREADABLE, contents
from fixtures_db.schema import Base

NO_ROW = "a row of the database"


def unreadable_row(session: Session, tables: tuple[Any, ...]) -> str:
    """Return table and key of the first row that cannot be read, else the tables that hold it."""
    connection = session.connection()
    for table in (Base.metadata.tables[one.__tablename__] for one in tables):
        if _is_read(connection, table):
            continue
        names = ", ".join(f'"{one.name}"' for one in table.primary_key)
        for key in connection.execute(text(f'SELECT {names} FROM "{table.name}"')).all():
            which = [one == value for one, value in zip(table.primary_key, key, strict=True)]
            if not _is_read(connection, table, *which):
                return f"{table.name} {', '.join(map(str, key))}"
    is_any = len(tables) == len(Base.metadata.tables)
    return NO_ROW if is_any else " or ".join(one.__tablename__ for one in tables)


def _is_read(connection: Connection, table: Table, *which: ColumnElement[bool]) -> bool:
    try:
        for _, content in contents(connection, table, *which):
            json.loads(content)
        if "document" in table.columns:
            for document in connection.execute(select(table.c.document).where(*which)).scalars():
                json.loads(document)
    except UNREADABLE:
        return False
    return True
