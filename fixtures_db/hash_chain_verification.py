"""What a database can say about whether it was altered."""

from collections.abc import Callable
from functools import partial
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.anchor import Anchor, missing_manifests
from fixtures_db.append_only_rows import ROW_TITLES, verify_dates, verify_rows
from fixtures_db.campaigns import verify_steps
from fixtures_db.hash_chain import GENESIS, ChainFault
from fixtures_db.issued import verify_issued
from fixtures_db.journal import Head
from fixtures_db.journal_verification import verify_journal
from fixtures_db.own_effects import verify_effects
from fixtures_db.row_content import UNREADABLE
from fixtures_db.schema import (
    Base,
    CalibrationRow,
    CampaignRow,
    CubeMeasurementRow,
    CubeRow,
    EffectEventRow,
    FaceCertificateRow,
    IssuedCertificateRow,
    SignedFileRow,
    SlabLevelRow,
    SlabRow,
    StepRow,
)
from fixtures_db.storage_checks import missing_tables, verify_storage
from fixtures_db.stored_calibrations import verify_chain
from fixtures_db.unreadable_rows import unreadable_row

CHAINED = tuple(ROW_TITLES)
Check = Callable[[Session], list[ChainFault]]
_EVERY = tuple(mapper.class_ for mapper in Base.registry.mappers)


def alterations(session: Session, anchor: Anchor | None = None) -> list[ChainFault]:
    """Return whatever disagrees with what was stored: a chain, a date, a row that the journal has otherwise.

    Entries dropped at the newest end show only against an ``anchor`` that was kept elsewhere.
    """
    kept = Anchor() if anchor is None else anchor
    if lost := missing_tables(session.connection()):
        return lost
    checks: tuple[tuple[Check, tuple[Any, ...]], ...] = (
        (partial(verify_chain, expected_head=kept.calibration), (CalibrationRow,)),
        (partial(verify_rows, table=FaceCertificateRow, expected_head=kept.certificate), (FaceCertificateRow,)),
        (partial(verify_rows, table=CubeMeasurementRow, expected_head=kept.measurement), (CubeMeasurementRow,)),
        (partial(verify_rows, table=SlabLevelRow, expected_head=kept.level), (SlabLevelRow,)),
        (partial(verify_issued, expected_head=kept.issued), (IssuedCertificateRow,)),
        (partial(verify_rows, table=SignedFileRow, expected_head=kept.signed), (SignedFileRow,)),
        (partial(verify_effects, expected_head=kept.effect), (EffectEventRow,)),
        (verify_dates, (CubeRow, SlabRow)),
        (verify_steps, (CampaignRow, StepRow)),
        (partial(missing_manifests, manifests=kept.manifests), (CampaignRow, StepRow)),
        (partial(verify_journal, kept=Head(kept.entries, kept.journal)), _EVERY),
        (verify_storage, _EVERY),
    )
    found = list[ChainFault]()
    for check, tables in checks:
        try:
            found += check(session)
        except UNREADABLE:
            found.append(ChainFault(unreadable_row(session, tables), "what cannot be read", "what was stored"))
    return found


def missing_head(session: Session, sha256: str) -> list[ChainFault]:
    """Return a fault if no row has a hash that was kept elsewhere, printed on a report or certificate."""
    if sha256 == GENESIS or sha256 in stored_hashes(session, sha256):
        return []
    return [ChainFault("stored rows", "none with the hash given", sha256)]


def stored_hashes(session: Session, digits: str) -> set[str]:
    """Return the hashes that begin with ``digits``: of chained rows, and of the accepted steps of campaigns."""
    columns: list[Any] = [table.sha256 for table in CHAINED] + [CampaignRow.manifest_sha256]
    return {one for column in columns for one in session.scalars(select(column).where(column.startswith(digits)))}
