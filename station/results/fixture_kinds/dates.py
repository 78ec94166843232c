"""Until when something holds, in words."""

from datetime import date

from fixtures_db.campaigns import is_expired
from fixtures_db.schema import CubeRow, SiteRow, SlabRow


def due_text(row: CubeRow | SlabRow | SiteRow) -> str:
    """Say until when a cube's, slab's or site's certificate holds, or since when no more."""
    if row.due_date is None:
        return "no due date"
    return f"{'expired on' if is_expired(row.due_date, date.today()) else 'due'} {row.due_date}"
