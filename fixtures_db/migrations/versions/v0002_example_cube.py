"""The cube of Yao, Hu, He 2018, table 2, as an example: 400 mm, every tolerance item 0.04 mm."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

ITEMS = (  # item, kind, face, against
    ("t1", "flatness", "A", None),
    ("t2", "flatness", "B", None),
    ("t3", "flatness", "C", None),
    ("t4-1", "perpendicularity", "C", "A"),
    ("t4-2", "perpendicularity", "C", "B"),
    ("t5", "flatness", "opposite A", None),
    ("t6", "flatness", "opposite B", None),
    ("t7", "flatness", "opposite C", None),
    ("t8", "parallelism", "opposite A", "A"),
    ("t9", "parallelism", "opposite B", "B"),
    ("t10", "parallelism", "opposite C", "C"),
)


def upgrade() -> None:
    """Add the cube and its eleven items."""
    cubes = sa.table("cubes", sa.column("id"), sa.column("side_mm"))
    op.bulk_insert(cubes, [{"id": "P1", "side_mm": 400.0}])
    names = ("cube_id", "item", "kind", "face", "reference_face", "tolerance_mm")
    items = sa.table("tolerance_items", *(sa.column(name) for name in names))
    op.bulk_insert(items, [dict(zip(names, ("P1", *item, 0.04), strict=True)) for item in ITEMS])
