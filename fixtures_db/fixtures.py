"""Cubes, slabs and sites by name, and what expires when; what is known of each stands in `fixtures_db.schema`."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, TypeVar

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.schema import CalibrationRow, CubeRow, SiteRow, SlabRow

FixtureRow = TypeVar("FixtureRow", bound=CubeRow | SlabRow | SiteRow)
KIND_NAMES: dict[type[Any], str] = {CubeRow: "cube", SlabRow: "slab", SiteRow: "site"}
SAME_PLACE_DEG = 1e-3  # 100 m: a latitude is typed with four decimals
GRAVITY_M_S2 = (9.7, 9.9)  # what the Earth's surface has


def add_fixture(session: Session, row: FixtureRow) -> FixtureRow:
    """Add a cube, slab or site.

    Raises
    ------
    AlreadyThere
        If the name is taken.
    ValueError
        If the side of a cube is no length, or a site is no place on the Earth.
    """
    if session.get(type(row), row.id) is not None:
        raise AlreadyThere(KIND_NAMES[type(row)], row.id)
    if isinstance(row, CubeRow) and not row.side_mm > 0:
        raise ValueError(f"side of cube {row.id!r} is {row.side_mm} mm, expected a positive length")
    if isinstance(row, SiteRow):
        check_site(row)
    session.add(row)
    session.flush()
    return row


def fixture_rows(session: Session, kind: type[FixtureRow]) -> Sequence[FixtureRow]:
    """Return all cubes, slabs or sites by name."""
    return session.scalars(select(kind).order_by(kind.id)).all()


def fixture_row(session: Session, kind: type[FixtureRow], name: str) -> FixtureRow:
    """Return one cube, slab or site; raise `NotInDatabase` if there is none of that name."""
    if (row := session.get(kind, name)) is None:
        raise NotInDatabase(KIND_NAMES[kind], name, [known.id for known in fixture_rows(session, kind)])
    return row


def check_site(row: SiteRow) -> None:
    """Raise `ValueError` if a row is no place on the Earth, or its gravity is none or has no sigma."""
    for word, value, most in (("latitude", row.latitude_deg, 90), ("longitude", row.longitude_deg, 180)):
        if value is not None and not abs(value) <= most:
            raise ValueError(f"{word} of site {row.id!r} is {value} deg, expected within {most} deg of 0")
    if (row.gravity_m_s2, row.gravity_std_m_s2) == (None, None):
        return
    g, std, (low, high) = row.gravity_m_s2, row.gravity_std_m_s2, GRAVITY_M_S2
    if g is None or std is None or not (low < g < high and 0 < std < 0.1):
        raise ValueError(f"gravity of site {row.id!r} is {g} +- {std} m/s2, expected {low} to {high} with 1 sigma")


def is_surveyed_at(row: SiteRow, latitude_deg: float, gravity_m_s2: float, gravity_std_m_s2: float) -> bool:
    """Say whether a gravity entered by hand comes from a site's survey.

    It is at the same latitude within 0.001 deg, and the value agrees with the survey's within the 1 sigma entered,
    which is not smaller than the survey's.
    """
    g, std = row.gravity_m_s2, row.gravity_std_m_s2
    return (
        g is not None
        and std is not None
        and abs(row.latitude_deg - latitude_deg) <= SAME_PLACE_DEG
        and std <= gravity_std_m_s2 * (1 + 1e-9)
        and abs(g - gravity_m_s2) <= gravity_std_m_s2
    )


@dataclass(frozen=True, slots=True, order=True)
class Due:
    """Something whose certificate, survey or calibration holds until the end of ``date``."""

    date: date
    kind: str
    name: str


def due(session: Session, until: date) -> list[Due]:
    """Return what has expired or does so by the day ``until``, the earliest first."""
    return sorted(one for one in _all(session) if one.date <= until)


def _all(session: Session) -> Iterator[Due]:
    for kind, word in KIND_NAMES.items():
        rows = fixture_rows(session, kind)
        yield from (Due(row.due_date, word, row.id) for row in rows if row.due_date is not None)
    newest = select(func.max(CalibrationRow.id)).group_by(CalibrationRow.imu_id)
    for row in session.scalars(select(CalibrationRow).where(CalibrationRow.id.in_(newest))):
        until = json.loads(row.document).get("valid_until")
        if until is not None:
            yield Due(datetime.fromisoformat(until).date(), "imu", f"{row.imu.model} {row.imu.serial}")
