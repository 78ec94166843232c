"""Cubes, certificates, slabs, sites, IMUs, campaigns, steps and calibrations."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.append_only import protect

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
        sa.Column("id", sa.String(), nullable=False),
        sa.Column("side_mm", sa.Double(), nullable=False),
        sa.Column("certificate_date", sa.Date()),
        sa.Column("due_date", sa.Date()),
        sa.PrimaryKeyConstraint("id", name="pk_cubes"),
    )
    op.create_table(
        "tolerance_items",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("cube_id", sa.String(), nullable=False),
        sa.Column("item", sa.String(), nullable=False),
        sa.Column("kind", sa.String(), nullable=False),
        sa.Column("face", sa.String(), nullable=False),
        sa.Column("reference_face", sa.String()),
        sa.Column("tolerance_mm", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_tolerance_items"),
        sa.ForeignKeyConstraint(["cube_id"], ["cubes.id"], name="fk_tolerance_items_cube_id"),
        sa.UniqueConstraint("cube_id", "item", name="uq_tolerance_items_cube_id"),
    )
    op.create_table(
        "face_certificates",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("cube_id", sa.String(), nullable=False),
        sa.Column("resting", sa.String(), nullable=False),
        sa.Column("up_tilt_1_rad", sa.Double(), nullable=False),
        sa.Column("up_tilt_2_rad", sa.Double(), nullable=False),
        sa.Column("covariance_11_rad2", sa.Double(), nullable=False),
        sa.Column("covariance_12_rad2", sa.Double(), nullable=False),
        sa.Column("covariance_22_rad2", sa.Double(), nullable=False),
        sa.Column("source", sa.String(), nullable=False),
        sa.Column("measured_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("due_date", sa.Date()),
        sa.Column("previous", sa.String(64), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_face_certificates"),
        sa.ForeignKeyConstraint(["cube_id"], ["cubes.id"], name="fk_face_certificates_cube_id"),
        sa.UniqueConstraint("previous", name="uq_face_certificates_previous"),
        sa.UniqueConstraint("sha256", name="uq_face_certificates_sha256"),
    )
    op.create_index("ix_face_certificates_cube_id", "face_certificates", ["cube_id"])
    op.create_table(
        "slabs",
        sa.Column("id", sa.String(), nullable=False),
        sa.Column("certificate_date", sa.Date()),
        sa.Column("due_date", sa.Date()),
        sa.PrimaryKeyConstraint("id", name="pk_slabs"),
    )
    op.create_table(
        "sites",
        sa.Column("id", sa.String(), nullable=False),
        sa.Column("latitude_deg", sa.Double(), nullable=False),
        sa.Column("longitude_deg", sa.Double()),
        sa.Column("height_m", sa.Double()),
        sa.Column("gravity_m_s2", sa.Double()),
        sa.Column("gravity_std_m_s2", sa.Double()),
        sa.PrimaryKeyConstraint("id", name="pk_sites"),
    )


def _units() -> None:
    op.create_table(
        "imus",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("model", sa.String(), nullable=False),
        sa.Column("serial", sa.String(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_imus"),
        sa.UniqueConstraint("model", "serial", name="uq_imus_model"),
    )
    op.create_index("ix_imus_serial", "imus", ["serial"])
    op.create_table(
        "campaigns",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("folder", sa.String(), nullable=False),
        sa.Column("imu_id", sa.Integer(), nullable=False),
        sa.Column("cube_id", sa.String()),
        sa.Column("slab_id", sa.String()),
        sa.Column("site_id", sa.String()),
        sa.Column("started_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(), nullable=False),
        sa.Column("manifest_sha256", sa.String(64), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_campaigns"),
        sa.ForeignKeyConstraint(["imu_id"], ["imus.id"], name="fk_campaigns_imu_id"),
        sa.ForeignKeyConstraint(["cube_id"], ["cubes.id"], name="fk_campaigns_cube_id"),
        sa.ForeignKeyConstraint(["slab_id"], ["slabs.id"], name="fk_campaigns_slab_id"),
        sa.ForeignKeyConstraint(["site_id"], ["sites.id"], name="fk_campaigns_site_id"),
        sa.UniqueConstraint("folder", name="uq_campaigns_folder"),
    )
    op.create_index("ix_campaigns_imu_id", "campaigns", ["imu_id"])
    op.create_table(
        "steps",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("campaign_id", sa.Integer(), nullable=False),
        sa.Column("name", sa.String(), nullable=False),
        sa.Column("file", sa.String(), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("accepted_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("superseded", sa.Boolean(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_steps"),
        sa.ForeignKeyConstraint(["campaign_id"], ["campaigns.id"], name="fk_steps_campaign_id"),
    )
    op.create_index("ix_steps_campaign_id", "steps", ["campaign_id"])


def _calibrations() -> None:
    op.create_table(
        "calibrations",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("imu_id", sa.Integer(), nullable=False),
        sa.Column("campaign_id", sa.Integer()),
        sa.Column("accepted_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("code_version", sa.String(), nullable=False),
        sa.Column("inputs", sa.JSON(), nullable=False),
        sa.Column("document", sa.Text(), nullable=False),
        sa.Column("previous", sa.String(64), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_calibrations"),
        sa.ForeignKeyConstraint(["imu_id"], ["imus.id"], name="fk_calibrations_imu_id"),
        sa.ForeignKeyConstraint(["campaign_id"], ["campaigns.id"], name="fk_calibrations_campaign_id"),
        sa.UniqueConstraint("previous", name="uq_calibrations_previous"),
        sa.UniqueConstraint("sha256", name="uq_calibrations_sha256"),
    )
    op.create_index("ix_calibrations_imu_id", "calibrations", ["imu_id"])
