"""A site as it is shown: position, and gravity with its source."""

from sqlalchemy.orm import Session

from fixtures_db.fixtures import fixture_row, fixture_rows
from fixtures_db.schema import SiteRow
from station.results.fixture_kinds import due_text


def lines(session: Session) -> list[str]:
    """Return a line for each site."""
    return [
        f"{row.id}: {_position(row)}, {_gravity(row)}, {due_text(row)}" for row in fixture_rows(session, SiteRow)
    ]


def description(session: Session, name: str) -> str:
    """Return a site's position and survey; raise `NotInDatabase` if there is none of that name."""
    row = fixture_row(session, SiteRow, name)
    source = f" ({row.gravity_source or 'no source'}, {row.gravity_date or 'no date'})" if row.gravity_m_s2 else ""
    return f"{row.id}: {_position(row)}\n  {_gravity(row)}{source}, {due_text(row)}"


def _position(row: SiteRow) -> str:
    longitude = "" if row.longitude_deg is None else f", longitude {row.longitude_deg:.6f} deg"
    height = "" if row.height_m is None else f", height {row.height_m:g} m"
    return f"latitude {row.latitude_deg:.6f} deg{longitude}{height}"


def _gravity(row: SiteRow) -> str:
    if row.gravity_m_s2 is None:
        return "gravity never surveyed"
    return f"gravity {row.gravity_m_s2:.7f} +- {row.gravity_std_m_s2:.1g} m/s2"
