"""Bring a database's schema to the newest version by alembic; triggers that make a table append-only."""

from pathlib import Path

from alembic import command, op
from alembic.config import Config
from sqlalchemy import Connection

from fixtures_db.append_only_rows import REFUSING_FUNCTION, on_postgresql, on_sqlite


def config() -> Config:
    """Return alembic's configuration; there is no alembic.ini."""
    made = Config()
    made.set_main_option("script_location", str(Path(__file__).parent).replace("%", "%%"))
    made.set_main_option("path_separator", "os")
    return made


def upgrade(connection: Connection) -> None:
    """Bring the schema to the newest version; all of it or, on an error, nothing."""
    made = config()
    made.attributes["connection"] = connection
    command.upgrade(made, "head")


def protect(table: str) -> None:
    """Make a chained table append-only: the database itself refuses UPDATE, DELETE and what replaces rows."""
    is_sqlite = op.get_bind().dialect.name == "sqlite"
    if not is_sqlite:
        made = "CREATE OR REPLACE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql"
        op.execute(f"{made} AS $$ {REFUSING_FUNCTION} $$")
    for statement in (on_sqlite if is_sqlite else on_postgresql)(table).values():
        op.execute(statement)
