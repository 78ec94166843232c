"""A slab as it is shown: its levels in arcsec, newest last."""

from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import in_force
from fixtures_db.fixtures import fixture_row, fixture_rows
from fixtures_db.schema import SlabLevelRow, SlabRow
from procedures.units import RAD_PER_ARCSEC
from station.results.fixture_kinds import due_text


def lines(session: Session) -> list[str]:
    """Return a line for each slab: its level in force."""
    return [f"{row.id}: {_level(in_force(row.levels))}, {due_text(row)}" for row in fixture_rows(session, SlabRow)]


def description(session: Session, name: str) -> str:
    """Return every level of a slab; raise `NotInDatabase` if there is none of that name."""
    row = fixture_row(session, SlabRow, name)
    said = [f"{row.id}: certificate {row.certificate_date or 'none'}, {due_text(row)}"]
    by_date = sorted(row.levels, key=lambda level: (level.measured_utc, level.id))
    return "\n".join([*said, *(f"  {_level(level)}" for level in by_date)])


def _level(row: SlabLevelRow | None) -> str:
    if row is None:
        return "level never measured"
    tilts = ("east", row.tilt_east_rad, row.std_east_rad), ("north", row.tilt_north_rad, row.std_north_rad)
    said = ", ".join(f"{way} {v / RAD_PER_ARCSEC:+z.2f} +- {s / RAD_PER_ARCSEC:.2f}" for way, v, s in tilts)
    return f"{said} arcsec ({row.source}, {row.measured_utc:%Y-%m-%d})"
