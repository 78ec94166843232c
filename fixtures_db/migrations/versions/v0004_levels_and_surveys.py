"""The level history of slabs; who surveyed a site's gravity, when, and until when it holds."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.upgrade import protect

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Create the append-only table of levels and add the survey's columns to sites."""
    op.create_table(
        "slab_levels",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("slab_id", sa.String(), sa.ForeignKey("slabs.id"), nullable=False, index=True),
        sa.Column("tilt_east_rad", sa.Double(), nullable=False),
        sa.Column("tilt_north_rad", sa.Double(), nullable=False),
        sa.Column("std_east_rad", sa.Double(), nullable=False),
        sa.Column("std_north_rad", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("measured_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("due_date", sa.Date()),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    protect("slab_levels")
    op.add_column("sites", sa.Column("gravity_source", sa.String()))
    op.add_column("sites", sa.Column("gravity_date", sa.Date()))
    op.add_column("sites", sa.Column("due_date", sa.Date()))
