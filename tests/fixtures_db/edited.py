"""A database as whoever owns it may leave it, looked at and taken back."""

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import Connection, text
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import append_only_tables, on_sqlite
from fixtures_db.database import Database


def free_to_write(connection: Connection) -> None:
    """Put triggers and references out of the way, as whoever owns the database can."""
    if connection.dialect.name == "postgresql":
        connection.execute(text("SET LOCAL session_replication_role = replica"))
        return
    connection.execute(text("PRAGMA defer_foreign_keys = ON"))
    for table in append_only_tables():
        for name in on_sqlite(table):
            connection.execute(text(f"DROP TRIGGER {name}"))


def put_back(connection: Connection) -> None:
    """Put the triggers back."""
    if connection.dialect.name == "sqlite":
        for table in append_only_tables():
            for statement in on_sqlite(table).values():
                connection.execute(text(statement))


@contextmanager
def edited(db: Database, *statements: str) -> Iterator[Session]:
    """Give a session in which statements are done, triggers and references out of the way; nothing is kept."""
    with db.engine.connect() as connection:
        free_to_write(connection)
        for statement in statements:
            connection.execute(text(statement))
        with Session(bind=connection) as session:
            yield session
