"""Cubes, certificates, slabs, sites, IMUs, campaigns, steps and calibrations."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.upgrade import protect

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Create the tables and the triggers of the append-only ones."""
    _fixtures()
    _units()
    _calibrations()
    for table in ("face_certificates", "calibrations"):
        protect(table)


def _fixtures() -> None:
    op.create_table(
        "cubes",
        sa.Column("id", sa.String(), primary_key=True),
        sa.Column("side_mm", sa.Double(), nullable=False),
        sa.Column("certificate_date", sa.Date()),
        sa.Column("due_date", sa.Date()),
    )
    op.create_table(
        "tolerance_items",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("cube_id", sa.String(), sa.ForeignKey("cubes.id"), nullable=False),
        sa.Column("item", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("face", sa.String(), nullable=False),
        sa.Column("reference_face", sa.String()),
        sa.Column("tolerance_mm", sa.Double(), nullable=False),
        sa.UniqueConstraint("cube_id", "item"),
    )
    op.create_table(
        "face_certificates",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("cube_id", sa.String(), sa.ForeignKey("cubes.id"), nullable=False, index=True),
        sa.Column("resting", sa.String(), nullable=False),
        sa.Column("up_tilt_1_rad", sa.Double(), nullable=False),
        sa.Column("up_tilt_2_rad", sa.Double(), nullable=False),
        sa.Column("covariance_11_rad2", sa.Double(), nullable=False),
        sa.Column("covariance_12_rad2", sa.Double(), nullable=False),
        sa.Column("covariance_22_rad2", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("measured_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("due_date", sa.Date()),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    op.create_table(
        "slabs",
        sa.Column("id", sa.String(), primary_key=True),
        sa.Column("certificate_date", sa.Date()),
        sa.Column("due_date", sa.Date()),
    )
    op.create_table(
        "sites",
        sa.Column("id", sa.String(), primary_key=True),
        sa.Column("latitude_deg", sa.Double(), nullable=False),
        sa.Column("longitude_deg", sa.Double()),
        sa.Column("height_m", sa.Double()),
        sa.Column("gravity_m_s2", sa.Double()),
        sa.Column("gravity_std_m_s2", sa.Double()),
    )


def _units() -> None:
    op.create_table(
        "imus",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("model", sa.String(), nullable=False),
        sa.Column("serial", sa.String(), nullable=False, index=True),
        sa.UniqueConstraint("model", "serial"),
    )
    op.create_table(
        "campaigns",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("folder", sa.String(), nullable=False, unique=True),
        sa.Column("imu_id", sa.Integer(), sa.ForeignKey("imus.id"), nullable=False, index=True),
        sa.Column("cube_id", sa.String(), sa.ForeignKey("cubes.id")),
        sa.Column("slab_id", sa.String(), sa.ForeignKey("slabs.id")),
        sa.Column("site_id", sa.String(), sa.ForeignKey("sites.id")),
        sa.Column("started_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("manifest_sha256", sa.String(64), nullable=False),
    )
    op.create_table(
        "steps",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("campaign_id", sa.Integer(), sa.ForeignKey("campaigns.id"), nullable=False, index=True),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("file", sa.String(), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("accepted_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("superseded", sa.Boolean(), nullable=False),
    )


def _calibrations() -> None:
    op.create_table(
        "calibrations",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("imu_id", sa.Integer(), sa.ForeignKey("imus.id"), nullable=False, index=True),
        sa.Column("campaign_id", sa.Integer(), sa.ForeignKey("campaigns.id")),
        sa.Column("accepted_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("code_version", sa.String(), nullable=False),
        sa.Column("inputs", sa.JSON(), nullable=False),
        sa.Column("document", sa.Text(), nullable=False),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
