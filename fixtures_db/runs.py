"""Stored calibrations with what they were made with: of one serial number, or of all units of a model."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session, joinedload

from fixtures_db.schema import CalibrationRow, CampaignRow, ImuRow

MADE_WITH = ("cube", "slab", "site", "operator")  # what may shift a calibration, beside the unit


@dataclass(frozen=True, slots=True)
class Run:
    """A calibration: ``document`` is calibration/1, ``ended`` when it was measured, ``made_with`` by `MADE_WITH`.

    ``recording`` names what it was solved from: calibrations that share it are one turn-on, solved again.
    """

    sha256: str
    model: str
    serial: str
    ended: datetime
    recording: str
    made_with: dict[str, str]
    document: dict[str, Any]


def stored_runs(session: Session, **of: str) -> list[Run]:
    """Return the calibrations of the IMUs of a ``serial`` or ``model``, in the order in which they were stored."""
    rows = select(CalibrationRow).join(ImuRow).filter_by(**of).order_by(CalibrationRow.id)
    with_owners = rows.options(joinedload(CalibrationRow.imu), joinedload(CalibrationRow.campaign))
    return [_run(row, row.campaign) for row in session.scalars(with_owners)]


def calibrated_models(session: Session) -> Sequence[str]:
    """Return the models that have a calibration."""
    return session.scalars(select(ImuRow.model).join(CalibrationRow).distinct().order_by(ImuRow.model)).all()


def turn_ons(runs: Iterable[Run]) -> list[Run]:
    """Return one run, the newest stored, of each recording, in the order in which they were measured."""
    newest = {(run.model, run.serial, run.recording): run for run in runs}
    return sorted(newest.values(), key=lambda run: run.ended)


def _run(row: CalibrationRow, campaign: CampaignRow | None) -> Run:
    document = json.loads(row.document)
    files = " ".join(sorted(row.inputs.values())) or row.sha256
    return Run(
        sha256=row.sha256,
        model=row.imu.model,
        serial=row.imu.serial,
        ended=_ended(document, row.accepted_utc),
        recording=files if campaign is None else f"campaign {campaign.id}",
        made_with=_made_with(document, campaign),
        document=document,
    )


def _ended(document: dict[str, Any], accepted: datetime) -> datetime:
    """Return when the measuring ended; calibrations stored before that was kept say when they were accepted."""
    said = document.get("procedure", {}).get("ended_utc")
    return accepted if said is None else datetime.fromisoformat(said).astimezone(UTC)


def _made_with(document: dict[str, Any], campaign: CampaignRow | None) -> dict[str, str]:
    found = {kind: getattr(campaign, f"{kind}_id", None) for kind in MADE_WITH[:3]}
    found |= {one["kind"]: one.get("id") for one in document.get("references", ())}
    found["site"] = document.get("site", {}).get("id", found["site"])
    found["operator"] = document.get("operator")
    return {kind: name for kind in MADE_WITH if (name := found.get(kind))}
