"""Campaigns and their accepted steps, as far as a station must remember them."""

from collections.abc import Mapping, Sequence
from datetime import UTC, date, datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import owners_rows_in_force
from fixtures_db.errors import AlreadyThere, CampaignInUse, NotInDatabase
from fixtures_db.hash_chain import GENESIS, ChainFault, canonical, digest, utc_text
from fixtures_db.schema import (
    CalibrationRow,
    CampaignRow,
    CubeMeasurementRow,
    CubeRow,
    FaceCertificateRow,
    ImuRow,
    SiteRow,
    SlabLevelRow,
    SlabRow,
    StepRow,
)

STATES = ("recording", "recorded", "accepted", "cancelled")


def imu(session: Session, model: str, serial: str) -> ImuRow:
    """Return the IMU of a model and serial number, added if it is new."""
    row = session.scalars(select(ImuRow).where(ImuRow.model == model, ImuRow.serial == serial)).first()
    if row is None:
        row = ImuRow(model=model, serial=serial)
        session.add(row)
        session.flush()
    return row


def is_known_imu(session: Session, model: str, serial: str | None) -> bool:
    """Say whether the database has an IMU of a model, with ``serial`` that one."""
    known = select(ImuRow).where(ImuRow.model == model)
    return session.scalars(known if serial is None else known.where(ImuRow.serial == serial)).first() is not None


def add_imu(session: Session, model: str, serial: str) -> ImuRow:
    """Add an IMU; raise `AlreadyThere` if it is known."""
    if session.scalars(select(ImuRow).where(ImuRow.model == model, ImuRow.serial == serial)).first() is not None:
        raise AlreadyThere("IMU", f"{model} {serial}")
    return imu(session, model, serial)


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
    effects_sha256: Sequence[str] | None = None,
) -> CampaignRow:
    """Add a campaign in state ``recording``; raise `AlreadyThere` if the folder is known.

    ``effects_sha256`` are the hashes of the effect/1 files in its folder, in their order.
    """
    if known_campaign(session, folder) is not None:
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
        effects_sha256=None if effects_sha256 is None else " ".join(effects_sha256),
    )
    session.add(row)
    session.flush()
    return row


def campaign(session: Session, folder: str) -> CampaignRow:
    """Return the campaign of a folder; raise `NotInDatabase` if there is none."""
    if (row := known_campaign(session, folder)) is None:
        known = session.scalars(select(CampaignRow.folder).order_by(CampaignRow.id.desc()).limit(5)).all()
        raise NotInDatabase("campaign", folder, known)
    return row


def known_campaign(session: Session, folder: str) -> CampaignRow | None:
    """Return the campaign of a folder, None if the database has none."""
    return session.scalars(select(CampaignRow).where(CampaignRow.folder == folder)).first()


def in_state(session: Session, state: str) -> Sequence[CampaignRow]:
    """Return the campaigns in a state, newest first."""
    rows = select(CampaignRow).where(CampaignRow.state == state)
    return session.scalars(rows.order_by(CampaignRow.started_utc.desc(), CampaignRow.id.desc())).all()


def complete_campaigns(session: Session) -> Sequence[CampaignRow]:
    """Return the campaigns whose recording was completed, oldest first."""
    rows = select(CampaignRow).where(CampaignRow.state.in_(("recorded", "accepted")))
    return session.scalars(rows.order_by(CampaignRow.started_utc, CampaignRow.id)).all()


def last_accepted(row: CampaignRow) -> datetime:
    """Return when a campaign's last step was accepted, its begin where none was."""
    return max([row.started_utc, *(step.accepted_utc for step in row.steps)])


def day_of(moment: datetime) -> date:
    """Return the day on which something was done: that of UTC, which a certificate prints, wherever it was."""
    return moment.astimezone(UTC).date()


def is_expired(due: date | None, on: date) -> bool:
    """Say whether a certificate due on ``due`` has run out ``on`` a day; one without a due date never does."""
    return due is not None and due < on


def remove_campaign(session: Session, folder: str) -> None:
    """Delete a campaign, its steps, and its IMU if nothing else names it: as if it had never been started.

    Raise `CampaignInUse` if a calibration was stored from it.
    """
    row = campaign(session, folder)
    unit, is_stored = row.imu, select(CalibrationRow.id).where(CalibrationRow.campaign_id == row.id)
    if session.scalars(is_stored.limit(1)).first() is not None:
        raise CampaignInUse(folder)
    for step in row.steps:
        session.delete(step)
    session.flush()
    session.delete(row)
    session.flush()
    users = (
        select(CampaignRow.id).where(CampaignRow.imu_id == unit.id),
        select(CalibrationRow.id).where(CalibrationRow.imu_id == unit.id),
    )
    if not any(session.scalars(user.limit(1)).all() for user in users):
        session.delete(unit)
        session.flush()


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
    return manifest_heads(steps)[-1]


def manifest_heads(steps: Sequence[StepRow]) -> list[str]:
    """Return the head of the chain after no, one, two ... of the accepted steps."""
    heads = [GENESIS]
    for step in steps:
        link = {"previous": heads[-1], "name": step.name, "file": step.file, "sha256": step.sha256}
        heads.append(digest(canonical(link)))
    return heads


def verify_steps(session: Session, folder: str | None = None) -> list[ChainFault]:
    """Return every campaign, or the one of ``folder``, whose accepted steps are not those that were accepted."""
    rows = select(CampaignRow).order_by(CampaignRow.id)
    if folder is not None:
        rows = rows.where(CampaignRow.folder == folder)
    return [fault for row in session.scalars(rows) for fault in _step_faults(row)]


def _step_faults(row: CampaignRow) -> list[ChainFault]:
    name, faults = f"steps of campaign {row.folder}", list[ChainFault]()
    if (head := manifest_head(row.steps)) != row.manifest_sha256:
        faults.append(ChainFault(name, f"head {head}", row.manifest_sha256))
    last = {step.name: step.id for step in row.steps}
    for step in row.steps:
        is_superseded = step.id != last[step.name]
        if step.superseded != is_superseded:
            state = {True: "superseded", False: "not superseded"}
            faults.append(ChainFault(f"{name}: {step.file}", state[step.superseded], state[is_superseded]))
    return faults


BY_IMUS = "the station's own campaigns with re-mounted IMUs"


def references(session: Session, folder: str) -> list[dict[str, Any]]:
    """Return cube, slab and site of a campaign as JSON-ready values; what is not known is left out.

    Each has ``kind`` and ``id``; where known, the SHA-256 of its newest ``certificate``, the ``source`` that
    measured it, ``measured_utc``, and ``due_date``: the first of those that were in force when the campaign's last
    step was accepted.
    """
    if (row := known_campaign(session, folder)) is None:
        return []
    until = last_accepted(row)
    rows = (
        row.cube_id and session.get(CubeRow, row.cube_id),
        row.slab_id and session.get(SlabRow, row.slab_id),
        row.site_id and session.get(SiteRow, row.site_id),
    )
    return [reference(one, until) for one in rows if one]


def reference(row: CubeRow | SlabRow | SiteRow, until: datetime) -> dict[str, Any]:
    """Return one of `references`, with the certificate that holds for it at a moment."""
    if isinstance(row, SiteRow):
        source = {} if row.gravity_source is None else {"source": row.gravity_source}
        return {"kind": "site", "id": row.id, **source, **_dates(row.gravity_date, row.due_date)}
    named: dict[str, Any] = {"kind": "slab", "id": row.id}
    if isinstance(row, CubeRow):
        named = {"kind": "cube", "id": row.id, "side_mm": row.side_mm}
    rows: list[FaceCertificateRow | CubeMeasurementRow | SlabLevelRow] = owners_rows_in_force(row, until)
    return named | (_certified(rows) if rows else _dates(row.certificate_date, row.due_date))


def why_measured(references: Sequence[Mapping[str, Any]], on: date) -> list[str]:
    """Say why a calibration that was finished ``on`` a day is `measured`, not `calibrated`; empty if it is.

    It is calibrated with a cube and a slab that each have a certificate: a record of who measured it. None of
    these, nor the survey of the gravity used, may have expired on that day.
    """
    used, found = {one["kind"]: one for one in references}, list[str]()
    for kind in ("cube", "slab", "site"):
        one = used.get(kind)
        if one is None:
            if kind != "site":
                found.append(f"no {kind} is named")
        elif (due := one.get("due_date")) is not None and is_expired(date.fromisoformat(due), on):
            found.append(f"the certificate of {kind} {one['id']} expired on {due}")
        elif kind != "site" and "source" not in one:
            found.append(f"{kind} {one['id']} has no certificate")
    return found


def _certified(rows: Sequence[FaceCertificateRow | CubeMeasurementRow | SlabLevelRow]) -> dict[str, Any]:
    newest = max(rows, key=lambda row: (row.measured_utc, row.id))
    sources = dict.fromkeys(BY_IMUS if isinstance(row, CubeMeasurementRow) else row.source for row in rows)
    due = [row.due_date for row in rows if row.due_date is not None]
    text = {
        "certificate": newest.sha256,
        "source": "; ".join(sources),
        "measured_utc": utc_text(newest.measured_utc),
    }
    return text | _dates(None, min(due, default=None))


def _dates(measured: date | None, due: date | None) -> dict[str, Any]:
    named = {"measured_utc": measured, "due_date": due}
    return {name: value.isoformat() for name, value in named.items() if value is not None}
