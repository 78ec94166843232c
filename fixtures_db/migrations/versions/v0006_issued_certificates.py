"""Certificates as they were handed out."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.upgrade import protect

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Create the append-only table of certificates."""
    op.create_table(
        "certificates",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("number", sa.String(), nullable=False, unique=True),
        sa.Column("replaces", sa.String()),
        sa.Column("calibration_sha256", sa.String(64), nullable=False, index=True),
        sa.Column("issued_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("laboratory", sa.String(), nullable=False),
        sa.Column("html", sa.Text(), nullable=False),
        sa.Column("html_sha256", sa.String(64), nullable=False, unique=True),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    protect("certificates")
