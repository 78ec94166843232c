"""Marble slabs: their names and until when their certificates hold."""

from collections.abc import Sequence
from datetime import date

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.errors import AlreadyThere
from fixtures_db.schema import SlabRow


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
