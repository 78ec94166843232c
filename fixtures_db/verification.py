"""What a database can say about whether it was altered.

An `Anchor` holds the heads of its hash chains: kept elsewhere, they show what was dropped or rewritten before
them. What cannot be read is named: tables are read whole, and row by row where one cannot be.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from sqlalchemy import ColumnElement, Connection, Table, select, text
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, newest_hash, verify_dates, verify_rows
from fixtures_db.campaigns import manifest_head, verify_steps
from fixtures_db.hash_chain import GENESIS, ChainFault
from fixtures_db.issued_certificates import verify_issued
from fixtures_db.journal import UNREADABLE, Head, contents, journal_head
from fixtures_db.journal_verification import verify_journal
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
from fixtures_db.user_effects import verify_effects

_HEADS: dict[str, type[Any]] = {
    "calibration": CalibrationRow,
    "certificate": FaceCertificateRow,
    "level": SlabLevelRow,
    "measurement": CubeMeasurementRow,
    "issued": IssuedCertificateRow,
    "signed": SignedFileRow,
    "effect": EffectEventRow,
}


@dataclass(frozen=True, slots=True)
class Anchor:
    """The newest hash of calibrations, face certificates, levels, measured cubes, issued and signed, effects.

    ``journal`` is the hash of the newest entry of the journal, ``entries`` its number. ``manifests`` holds, by
    campaign folder, how many steps were accepted and the head of their chain.
    """

    calibration: str = GENESIS
    certificate: str = GENESIS
    level: str = GENESIS
    measurement: str = GENESIS
    issued: str = GENESIS
    signed: str = GENESIS
    effect: str = GENESIS
    journal: str = GENESIS
    entries: int = 0
    manifests: Mapping[str, tuple[int, str]] = field(default_factory=dict)

    @property
    def code(self) -> str:
        """The journal's length and the begin of its newest hash, as printed."""
        return Head(self.entries, self.journal).code


def take_anchor(session: Session) -> Anchor:
    """Return the heads as they are; a campaign being recorded, which may still be cancelled, is left out."""
    head = journal_head(session)
    ended = select(CampaignRow).where(CampaignRow.state != "recording").order_by(CampaignRow.id)
    return Anchor(
        **{name: newest_hash(session, table) for name, table in _HEADS.items()},
        journal=head.sha256,
        entries=head.entries,
        manifests={row.folder: (len(row.steps), row.manifest_sha256) for row in session.scalars(ended)},
    )


def missing_manifests(session: Session, manifests: Mapping[str, tuple[int, str]]) -> list[ChainFault]:
    """Return every campaign of an anchor that is gone, or whose steps do not begin with those of then."""
    rows, found = {row.folder: row for row in session.scalars(select(CampaignRow))}, list[ChainFault]()
    for folder, (steps, sha256) in manifests.items():
        if (row := rows.get(folder)) is None:
            found.append(ChainFault(f"campaign {folder}", "none", f"one of {steps} steps as in the anchor"))
        elif (head := manifest_head(row.steps[:steps])) != sha256:
            found.append(ChainFault(f"steps of campaign {folder}", f"head {head}", f"{sha256} as in the anchor"))
    return found


NO_ROW = "a row of the database"


def unreadable_row(session: Session, tables: tuple[Any, ...]) -> str:
    """Return table and key of the first row that cannot be read, else the tables that hold it."""
    connection = session.connection()
    for table in (Base.metadata.tables[one.__tablename__] for one in tables):
        if _is_read(connection, table):
            continue
        names = ", ".join(f'"{one.name}"' for one in table.primary_key)
        for key in connection.execute(text(f'SELECT {names} FROM "{table.name}"')).all():
            which = [one == value for one, value in zip(table.primary_key, key, strict=True)]
            if not _is_read(connection, table, *which):
                return f"{table.name} {', '.join(map(str, key))}"
    is_any = len(tables) == len(Base.metadata.tables)
    return NO_ROW if is_any else " or ".join(one.__tablename__ for one in tables)


def _is_read(connection: Connection, table: Table, *which: ColumnElement[bool]) -> bool:
    try:
        for _, content in contents(connection, table, *which):
            json.loads(content)
        if "document" in table.columns:
            for document in connection.execute(select(table.c.document).where(*which)).scalars():
                json.loads(document)
    except UNREADABLE:
        return False
    return True


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
