"""What IMUs measured of cubes; a cube is due when the first of its faces is."""

import sqlalchemy as sa
from alembic import op

from fixtures_db.migrations.upgrade import protect

revision = "0005"
down_revision = "0004"

FIRST_DUE = """
UPDATE cubes SET due_date = (
    SELECT MIN(f.due_date) FROM face_certificates f WHERE f.cube_id = cubes.id AND NOT EXISTS (
        SELECT 1 FROM face_certificates g WHERE g.cube_id = f.cube_id AND g.resting = f.resting
        AND (g.measured_utc > f.measured_utc OR (g.measured_utc = f.measured_utc AND g.id > f.id))))
WHERE EXISTS (SELECT 1 FROM face_certificates f WHERE f.cube_id = cubes.id)
"""  # until now it was due with the face measured last, and never where that one had no due date


def upgrade() -> None:
    """Create the append-only table of measurements and date the cubes again."""
    op.create_table(
        "cube_measurements",
        sa.Column("id", sa.Integer(), primary_key=True),
        sa.Column("cube_id", sa.String(), sa.ForeignKey("cubes.id"), nullable=False, index=True),
        sa.Column("values_rad", sa.Text(), nullable=False),
        sa.Column("covariance_rad2", sa.Text(), nullable=False),
        sa.Column("sources", sa.Text(), nullable=False),
        sa.Column("measured_utc", sa.DateTime(timezone=True), nullable=False),
        sa.Column("due_date", sa.Date()),
        sa.Column("previous", sa.String(64), nullable=False, unique=True),
        sa.Column("sha256", sa.String(64), nullable=False, unique=True),
    )
    protect("cube_measurements")
    op.execute(FIRST_DUE)
