"""The effects of one's own that a campaign began with."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Add their hashes to campaigns; of those that were begun before it is not known."""
    op.add_column("campaigns", sa.Column("effects_sha256", sa.Text()))
