"""The journal of all rows: what a database has already is carried over, as it stands on this day."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.journal import carry_over
from fixtures_db.migrations.upgrade import protect

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    """Create the append-only journal and write an entry for each row."""
    op.create_table(
        "journal",
        sa.Column("id", sa.Integer(), primary_key=True, autoincrement=False),
        sa.Column("table_name", sa.String(), nullable=False),
        sa.Column("row_key", sa.String(), nullable=False),
        sa.Column("event", sa.String(), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("recorded_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    protect("journal")
    carry_over(op.get_bind())
