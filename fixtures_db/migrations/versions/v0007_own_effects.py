"""Effects of one's own: added to a model or a unit, withdrawn again."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.upgrade import protect

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Create the append-only table of what became of effects."""
    op.create_table(
        "effect_events",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("event", sa.String(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("model", sa.String(), nullable=False),
        sa.Column("serial", sa.String()),
        sa.Column("effect_sha256", sa.String(64), nullable=False, index=True),
        sa.Column("definition", sa.Text(), nullable=False),
        sa.Column("recorded_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    protect("effect_events")
