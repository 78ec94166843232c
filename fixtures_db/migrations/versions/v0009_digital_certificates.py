"""Certificates as XML with their HTML."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the XML and its hash to certificates; those that were issued before have none."""
    op.add_column("certificates", sa.Column("dcc", sa.Text()))
    op.add_column("certificates", sa.Column("dcc_sha256", sa.String(64)))
