"""Sites: where a slab stands, and gravity as surveyed there."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Protocol

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.schema import SiteRow

SAME_PLACE_DEG = 1e-3  # 100 m: a latitude is typed with four decimals
GRAVITY = (9.7, 9.9)  # m/s^2: what the Earth's surface has


@dataclass(frozen=True, slots=True)
class Survey:
    """Gravity as surveyed [m/s^2] with its 1 sigma: by whom and how, when, and until when it holds."""

    gravity_m_s2: float
    std_m_s2: float
    source: str
    on: date | None = None
    due_date: date | None = None


def add_site(
    session: Session,
    site_id: str,
    *,
    latitude_deg: float,
    longitude_deg: float | None = None,
    height_m: float | None = None,
    survey: Survey | None = None,
) -> SiteRow:
    """Add a site by its geodetic position; raise `AlreadyThere` if the name is taken."""
    if session.get(SiteRow, site_id) is not None:
        raise AlreadyThere("site", site_id)
    row = SiteRow(id=site_id, latitude_deg=latitude_deg, longitude_deg=longitude_deg, height_m=height_m)
    if survey is not None:
        row.gravity_m_s2, row.gravity_std_m_s2 = survey.gravity_m_s2, survey.std_m_s2
        row.gravity_source, row.gravity_date, row.due_date = survey.source, survey.on, survey.due_date
    check_site(row)
    session.add(row)
    session.flush()
    return row


def check_site(row: SiteRow) -> None:
    """Raise `ValueError` if a row is no place on the Earth, or its gravity is none or has no sigma."""
    for word, value, most in (("latitude", row.latitude_deg, 90), ("longitude", row.longitude_deg, 180)):
        if value is not None and not abs(value) <= most:
            raise ValueError(f"{word} of site {row.id!r} is {value} deg, expected within {most} deg of 0")
    if (row.gravity_m_s2, row.gravity_std_m_s2) == (None, None):
        return
    g, std = row.gravity_m_s2, row.gravity_std_m_s2
    if g is None or std is None or not (GRAVITY[0] < g < GRAVITY[1] and 0 < std < 0.1):
        raise ValueError(
            f"gravity of site {row.id!r} is {g} +- {std} m/s2, expected {GRAVITY[0]} to {GRAVITY[1]} with 1 sigma"
        )


def sites(session: Session) -> Sequence[SiteRow]:
    """Return all sites by name."""
    return session.scalars(select(SiteRow).order_by(SiteRow.id)).all()


def surveyed_site(
    session: Session, *, latitude_deg: float, gravity_m_s2: float, gravity_std_m_s2: float
) -> SiteRow | None:
    """Return the site whose survey a gravity entered by hand comes from, None if there is none.

    It is at the same latitude within 0.001 deg, and the value agrees with the survey's within the 1 sigma entered,
    which is not smaller than the survey's.
    """
    stated = latitude_deg, gravity_m_s2, gravity_std_m_s2
    return next((row for row in sites(session) if is_surveyed_at(row, *stated)), None)


class Surveyed(Protocol):
    """What `is_surveyed_at` needs of a site."""

    @property
    def latitude_deg(self) -> float:
        """Geodetic latitude."""
        ...

    @property
    def gravity_m_s2(self) -> float | None:
        """As surveyed, None if it was not."""
        ...

    @property
    def gravity_std_m_s2(self) -> float | None:
        """Its 1 sigma."""
        ...


def is_surveyed_at(row: Surveyed, latitude_deg: float, gravity_m_s2: float, gravity_std_m_s2: float) -> bool:
    """Say whether a gravity entered by hand comes from a site's survey, as `surveyed_site` has it."""
    g, std = row.gravity_m_s2, row.gravity_std_m_s2
    return (
        g is not None
        and std is not None
        and abs(row.latitude_deg - latitude_deg) <= SAME_PLACE_DEG
        and std <= gravity_std_m_s2 * (1 + 1e-9)
        and abs(g - gravity_m_s2) <= gravity_std_m_s2
    )


def site_row(session: Session, site_id: str) -> SiteRow:
    """Return one site's row; raise `NotInDatabase` if there is none of that name."""
    if (row := session.get(SiteRow, site_id)) is None:
        raise NotInDatabase("site", site_id, [known.id for known in sites(session)])
    return row
