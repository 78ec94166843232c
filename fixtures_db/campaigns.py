"""Campaigns and their accepted steps, as far as a station must remember them."""

from collections.abc import Sequence
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.chain import GENESIS, canonical, digest
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.schema import CampaignRow, ImuRow, StepRow

STATES = ("recording", "recorded", "accepted", "cancelled")


def imu(session: Session, model: str, serial: str) -> ImuRow:
    """Return the IMU of a model and serial number, added if it is new."""
    row = session.scalars(select(ImuRow).where(ImuRow.model == model, ImuRow.serial == serial)).first()
    if row is None:
        row = ImuRow(model=model, serial=serial)
        session.add(row)
        session.flush()
    return row


def start_campaign(
    session: Session,
    folder: str,
    *,
    model: str,
    serial: str,
    started_utc: datetime,
    cube_id: str | None = None,
    slab_id: str | None = None,
    site_id: str | None = None,
) -> CampaignRow:
    """Add a campaign in state ``recording``; raise `AlreadyThere` if the folder is known."""
    if session.scalars(select(CampaignRow).where(CampaignRow.folder == folder)).first() is not None:
        raise AlreadyThere("campaign", folder)
    row = CampaignRow(
        folder=folder,
        imu=imu(session, model, serial),
        cube_id=cube_id,
        slab_id=slab_id,
        site_id=site_id,
        started_utc=started_utc,
        state="recording",
        manifest_sha256=GENESIS,
    )
    session.add(row)
    session.flush()
    return row


def campaign(session: Session, folder: str) -> CampaignRow:
    """Return the campaign of a folder; raise `NotInDatabase` if there is none."""
    row = session.scalars(select(CampaignRow).where(CampaignRow.folder == folder)).first()
    if row is None:
        known = session.scalars(select(CampaignRow.folder).order_by(CampaignRow.id.desc()).limit(5)).all()
        raise NotInDatabase("campaign", folder, known)
    return row


def set_state(session: Session, folder: str, state: str) -> None:
    """Move a campaign to one of `STATES`."""
    if state not in STATES:
        raise ValueError(f"campaign state {state!r} is none of {', '.join(STATES)}")
    campaign(session, folder).state = state


def accept_step(
    session: Session, folder: str, *, name: str, file: str, sha256: str, accepted_utc: datetime
) -> StepRow:
    """Append an accepted step and extend the campaign's manifest; an earlier step of that name is superseded."""
    owner = campaign(session, folder)
    for earlier in owner.steps:
        if earlier.name == name:
            earlier.superseded = True
    row = StepRow(name=name, file=file, sha256=sha256, accepted_utc=accepted_utc, superseded=False)
    owner.steps.append(row)
    owner.manifest_sha256 = manifest_head(owner.steps)
    session.flush()
    return row


def manifest_head(steps: Sequence[StepRow]) -> str:
    """Return the head of the hash chain over accepted steps, superseded ones included, in their order."""
    head = GENESIS
    for step in steps:
        head = digest(canonical({"previous": head, "name": step.name, "file": step.file, "sha256": step.sha256}))
    return head
