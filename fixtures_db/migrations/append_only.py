"""Triggers that refuse to change or delete rows of a table."""

from alembic import op


def protect(table: str) -> None:
    """Make a chained table append-only: UPDATE, DELETE and REPLACE are refused by the database itself."""
    if op.get_bind().dialect.name != "sqlite":
        raise NotImplementedError(f"append-only triggers of {table} are written for SQLite only")
    for action in ("UPDATE", "DELETE"):
        op.execute(
            f"CREATE TRIGGER {table}_no_{action.lower()} BEFORE {action} ON {table} "
            f"BEGIN SELECT RAISE(ABORT, '{table} is append-only'); END"
        )
    # INSERT OR REPLACE deletes without firing a DELETE trigger
    op.execute(
        f"CREATE TRIGGER {table}_no_replace BEFORE INSERT ON {table} WHEN EXISTS "
        f"(SELECT 1 FROM {table} WHERE id = NEW.id OR previous = NEW.previous OR sha256 = NEW.sha256) "
        f"BEGIN SELECT RAISE(ABORT, '{table} is append-only'); END"
    )
