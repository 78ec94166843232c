"""Triggers that refuse to change or delete rows of a table."""

from alembic import op


def protect(table: str) -> None:
    """Make a chained table append-only: the database itself refuses UPDATE, DELETE and what replaces rows."""
    {"sqlite": _on_sqlite, "postgresql": _on_postgresql}[op.get_bind().dialect.name](table)


def _on_sqlite(table: str) -> None:
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


def _on_postgresql(table: str) -> None:
    op.execute(
        "CREATE OR REPLACE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS "
        "$$ BEGIN RAISE EXCEPTION '% is append-only', TG_TABLE_NAME; END $$"
    )
    for action in ("UPDATE", "DELETE", "TRUNCATE"):  # ON CONFLICT DO UPDATE fires the one of UPDATE
        op.execute(
            f"CREATE TRIGGER {table}_no_{action.lower()} BEFORE {action} ON {table} "
            f"FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()"
        )
