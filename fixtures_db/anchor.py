"""The heads of a database's hash chains: kept elsewhere, they show what was dropped or rewritten before them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import newest_hash
from fixtures_db.campaigns import manifest_head
from fixtures_db.hash_chain import GENESIS, ChainFault
from fixtures_db.journal import Head, journal_head
from fixtures_db.schema import (
    CalibrationRow,
    CampaignRow,
    CubeMeasurementRow,
    EffectEventRow,
    FaceCertificateRow,
    IssuedCertificateRow,
    SignedFileRow,
    SlabLevelRow,
)

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
