"""Limits of IMU models."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Create the table."""
    op.create_table(
        "imu_limits",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(), nullable=False),
        sa.Column("parameter", sa.String(), nullable=False),
        sa.Column("low", sa.Double()),
        sa.Column("high", sa.Double()),
        sa.Column("unit", sa.String(), nullable=False),
        sa.Column("guard_band", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_imu_limits"),
        sa.UniqueConstraint("model", "parameter", name="uq_imu_limits_model"),
    )
