"""Triggers that refuse to change or delete rows of a table."""

from alembic import op

from fixtures_db.append_only_triggers import REFUSING_FUNCTION, on_postgresql, on_sqlite


def protect(table: str) -> None:
    """Make a chained table append-only: the database itself refuses UPDATE, DELETE and what replaces rows."""
    is_sqlite = op.get_bind().dialect.name == "sqlite"
    if not is_sqlite:
        made = "CREATE OR REPLACE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql"
        op.execute(f"{made} AS $$ {REFUSING_FUNCTION} $$")
    for statement in (on_sqlite if is_sqlite else on_postgresql)(table).values():
        op.execute(statement)
