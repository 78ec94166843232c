"""A database as whoever owns it may leave it, looked at and taken back."""

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import text
from sqlalchemy.orm import Session

from fixtures_db.database import Database
from tests.benchmarks.database_edits import free_to_write


@contextmanager
def edited(db: Database, *statements: str) -> Iterator[Session]:
    """Give a session in which statements are done, triggers and references out of the way; nothing is kept."""
    with db.engine.connect() as connection:
        free_to_write(connection)
        for statement in statements:
            connection.execute(text(statement))
        with Session(bind=connection) as session:
            yield session
