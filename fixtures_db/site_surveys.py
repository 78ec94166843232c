"""Which site's survey a gravity that was entered by hand comes from."""

from sqlalchemy.orm import Session

from fixtures_db.fixtures import fixture_rows
from fixtures_db.schema import SiteRow

SAME_PLACE_DEG = 1e-3  # 100 m: a latitude is typed with four decimals


def surveyed_site(
    session: Session, *, latitude_deg: float, gravity_m_s2: float, gravity_std_m_s2: float
) -> SiteRow | None:
    """Return the site whose survey a gravity entered by hand comes from, None if there is none.

    It is at the same latitude within 0.001 deg, and the value agrees with the survey's within the 1 sigma entered,
    which is not smaller than the survey's.
    """
    stated = latitude_deg, gravity_m_s2, gravity_std_m_s2
    return next((row for row in fixture_rows(session, SiteRow) if is_surveyed_at(row, *stated)), None)


def is_surveyed_at(row: SiteRow, latitude_deg: float, gravity_m_s2: float, gravity_std_m_s2: float) -> bool:
    """Say whether a gravity entered by hand comes from a site's survey, as `surveyed_site` has it."""
    g, std = row.gravity_m_s2, row.gravity_std_m_s2
    return (
        g is not None
        and std is not None
        and abs(row.latitude_deg - latitude_deg) <= SAME_PLACE_DEG
        and std <= gravity_std_m_s2 * (1 + 1e-9)
        and abs(g - gravity_m_s2) <= gravity_std_m_s2
    )
