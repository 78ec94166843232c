"""What a database can say about whether it was altered; read row by row where it cannot be read whole."""

from collections.abc import Callable
from functools import partial
from typing import Any

from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from fixtures_db.anchor import Anchor, missing_manifests
from fixtures_db.campaigns import verify_steps
from fixtures_db.chain import ChainFault
from fixtures_db.chained import verify_dates
from fixtures_db.cubes import verify_certificates
from fixtures_db.history import verify_chain
from fixtures_db.schema import (
    CalibrationRow,
    CampaignRow,
    CubeRow,
    FaceCertificateRow,
    SlabLevelRow,
    SlabRow,
    StepRow,
)
from fixtures_db.slabs import verify_levels

Check = Callable[[Session], list[ChainFault]]
_UNREADABLE = (SQLAlchemyError, ValueError, TypeError)  # bytes that are no text, text that is no date or JSON


def alterations(session: Session, anchor: Anchor | None = None) -> list[ChainFault]:
    """Return whatever disagrees with what was stored: calibrations, certificates, levels, accepted steps.

    Rows dropped at the newest end show only against an ``anchor`` that was kept elsewhere.
    """
    kept = Anchor() if anchor is None else anchor
    checks: tuple[tuple[Check, tuple[Any, ...]], ...] = (
        (partial(verify_chain, expected_head=kept.calibration), (CalibrationRow,)),
        (partial(verify_certificates, expected_head=kept.certificate), (FaceCertificateRow,)),
        (partial(verify_levels, expected_head=kept.level), (SlabLevelRow,)),
        (verify_dates, (CubeRow, SlabRow)),
        (verify_steps, (CampaignRow, StepRow)),
        (partial(missing_manifests, manifests=kept.manifests), (CampaignRow, StepRow)),
    )
    found = list[ChainFault]()
    for check, tables in checks:
        try:
            found += check(session)
        except _UNREADABLE:
            found.append(ChainFault(_unreadable(session, tables), "what cannot be read", "what was stored"))
    return found


def _unreadable(session: Session, tables: tuple[Any, ...]) -> str:
    for table in tables:
        for number in session.scalars(select(table.id).order_by(table.id)).all():
            try:
                session.expunge_all()
                session.get_one(table, number)
            except _UNREADABLE:
                return f"{table.__tablename__} {number}"
    return str(tables[0].__tablename__)
