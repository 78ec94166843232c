"""Which cubes there are: what a list of them needs, and no numerics."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.schema import CubeRow


def cubes(session: Session) -> Sequence[CubeRow]:
    """Return all cubes by name."""
    return session.scalars(select(CubeRow).order_by(CubeRow.id)).all()
