"""Marble slabs: their names, and how level they were found over the years."""

from collections.abc import Sequence
from datetime import date, datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.chain import ChainFault
from fixtures_db.chained import append, date_owner, verify_rows
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.schema import SlabLevelRow, SlabRow

MAX_TILT = 0.1  # rad; beyond it a tilt is a slip of the pen


def add_slab(
    session: Session, slab_id: str, *, certificate_date: date | None = None, due_date: date | None = None
) -> SlabRow:
    """Add a slab; raise `AlreadyThere` if the name is taken."""
    if session.get(SlabRow, slab_id) is not None:
        raise AlreadyThere("slab", slab_id)
    row = SlabRow(id=slab_id, certificate_date=certificate_date, due_date=due_date)
    session.add(row)
    session.flush()
    return row


def slabs(session: Session) -> Sequence[SlabRow]:
    """Return all slabs by name."""
    return session.scalars(select(SlabRow).order_by(SlabRow.id)).all()


def slab_row(session: Session, slab_id: str) -> SlabRow:
    """Return one slab's row; raise `NotInDatabase` if there is none of that name."""
    if (row := session.get(SlabRow, slab_id)) is None:
        raise NotInDatabase("slab", slab_id, [known.id for known in slabs(session)])
    return row


def add_level(
    session: Session,
    slab_id: str,
    *,
    tilt_rad: tuple[float, float],
    std_rad: tuple[float, float],
    source: str,
    measured_utc: datetime,
    due_date: date | None = None,
) -> SlabLevelRow:
    """Append how a slab was found; what was measured earlier stays.

    ``tilt_rad`` holds the east and north components of the up vector seen from the slab, as `solve` gives its
    ``slab.tilt`` [rad], ``std_rad`` their 1 sigma; ``source`` says who measured, and with what.
    """
    slab = slab_row(session, slab_id)
    row = SlabLevelRow(
        slab_id=slab_id,
        tilt_east_rad=tilt_rad[0],
        tilt_north_rad=tilt_rad[1],
        std_east_rad=std_rad[0],
        std_north_rad=std_rad[1],
        source=source,
        measured_utc=measured_utc,
        due_date=due_date,
    )
    check_level(row)
    append(session, row)
    date_owner(session, slab)
    return row


def check_level(row: SlabLevelRow) -> None:
    """Raise `ValueError` if a row is no level of a slab."""
    for tilt, std in ((row.tilt_east_rad, row.std_east_rad), (row.tilt_north_rad, row.std_north_rad)):
        if not (abs(tilt) < MAX_TILT and 0 < std < MAX_TILT):
            raise ValueError(
                f"level of slab {row.slab_id!r} is {tilt} +- {std} rad, expected a tilt under {MAX_TILT} rad and "
                f"its 1 sigma above 0"
            )


def verify_levels(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every level that was altered, dropped or reordered since it was stored."""
    return verify_rows(session, SlabLevelRow, "slab level", expected_head)
