"""Run alembic on a connection that is in a transaction already."""

from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import Connection


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
