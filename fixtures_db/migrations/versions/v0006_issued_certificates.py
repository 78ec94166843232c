"""Certificates as they were handed out."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.append_only import protect

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Create the append-only table of certificates."""
    op.create_table(
        "certificates",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("number", sa.String(), nullable=False),
        sa.Column("replaces", sa.String()),
        sa.Column("calibration_sha256", sa.String(64), nullable=False),
        sa.Column("issued_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("laboratory", sa.String(), nullable=False),
        sa.Column("html", sa.Text(), nullable=False),
        sa.Column("html_sha256", sa.String(64), nullable=False),
        sa.Column("previous", sa.String(64), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_certificates"),
        sa.UniqueConstraint("number", name="uq_certificates_number"),
        sa.UniqueConstraint("html_sha256", name="uq_certificates_html_sha256"),
        sa.UniqueConstraint("previous", name="uq_certificates_previous"),
        sa.UniqueConstraint("sha256", name="uq_certificates_sha256"),
    )
    op.create_index("ix_certificates_calibration_sha256", "certificates", ["calibration_sha256"])
    protect("certificates")
