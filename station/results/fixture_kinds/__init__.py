"""The kinds of fixtures as they are shown, one file each; a line here puts a kind on the list.

A kind's file has ``lines(session)``, one line for each of that kind by name, and ``description(session, name)``.
"""

from datetime import date

from fixtures_db.campaigns import is_expired
from fixtures_db.schema import CubeRow, SiteRow, SlabRow

KINDS = {
    "cube": "station.results.fixture_kinds.cube",
    "slab": "station.results.fixture_kinds.slab",
    "site": "station.results.fixture_kinds.site",
    "imu": "station.results.fixture_kinds.imu",
}


def due_text(row: CubeRow | SlabRow | SiteRow) -> str:
    """Say until when a cube's, slab's or site's certificate holds, or since when no more."""
    if row.due_date is None:
        return "no due date"
    return f"{'expired on' if is_expired(row.due_date, date.today()) else 'due'} {row.due_date}"
