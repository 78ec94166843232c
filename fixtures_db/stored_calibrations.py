"""Every calibration ever accepted, append-only, each naming the hash of the one before it.

A calibration is stored as `calibration/1`: what is applied to counts, ``u = E^-1 (N / k - D)``. A `Run` is one of
them with what it was made with: of one serial number, or of all units of a model.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np
from sqlalchemy import Select, select
from sqlalchemy.orm import Session, joinedload

from fixtures_db.append_only_rows import chained, newest_hash, verify_rows
from fixtures_db.campaigns import campaign, imu, known_campaign, manifest_heads
from fixtures_db.errors import AlreadyStored, LimitsChanged, NotInDatabase
from fixtures_db.hash_chain import ChainFault, canonical, utc_text
from fixtures_db.imu_models import Limit, limits_of
from fixtures_db.journal import journal_head
from fixtures_db.journal_verification import used_now
from fixtures_db.schema import CalibrationRow, CampaignRow, ImuRow
from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.frames import TRIADS

FORMAT = "calibration/1"
_MAPPINGS = ("residual", "procedure", "site", "uncertainty", "diagnosis")  # of `CalibrationFacts`
STATUSES = ("calibrated", "measured")


@dataclass(frozen=True, slots=True)
class CalibrationFacts:
    """What a calibration states besides its numbers.

    ``inputs`` holds the SHA-256 of each file used, by name; ``software`` is name, version and commit;
    ``temperature_range_c`` the least and the greatest temperature seen, None if never measured; ``status`` is
    ``measured`` where a reference lacked or had expired, ``status_reason`` says which. ``verdict`` is the one
    against ``limits``, the model's as they were then; None where nobody judged. ``judged`` holds what each limit
    was held against. What a certificate needs and only the station knew is there too: ``residual`` as in
    solution/1, how it was measured (``procedure``), where (``site``) and with what (``references``), and
    ``uncertainty``, a budget/1 of its parameters; ``diagnosis`` is the verdict on the residual with its findings;
    all JSON-ready.
    """

    model: str
    serial: str
    software: str
    inputs: Mapping[str, str]
    accepted_utc: datetime
    valid_from: datetime
    valid_until: datetime | None = None
    temperature_range_c: tuple[float, float] | None = None
    status: str = "calibrated"
    status_reason: str = ""
    operator: str = ""
    verdict: str | None = None
    limits: tuple[Limit, ...] = ()
    judged: tuple[Mapping[str, Any], ...] = ()
    residual: Mapping[str, Any] = field(default_factory=dict)
    procedure: Mapping[str, Any] = field(default_factory=dict)
    site: Mapping[str, Any] = field(default_factory=dict)
    references: tuple[Mapping[str, Any], ...] = ()
    uncertainty: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[Mapping[str, Any], ...] = field(default=())
    diagnosis: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise ValueError(f"calibration status {self.status!r} is none of {', '.join(STATUSES)}")


def calibration_document(solution: Solution, facts: CalibrationFacts, previous: str) -> dict[str, Any]:
    """Return calibration/1 as JSON-ready values; what was not estimated is left out.

    ``previous`` is the SHA-256 of the calibration accepted before this one, 64 zeros for the first.
    """
    document: dict[str, Any] = {
        "format": FORMAT,
        "model": facts.model,
        "serial": facts.serial,
        "software": facts.software,
        "status": facts.status,
        "accepted_utc": utc_text(facts.accepted_utc),
        "valid_from": utc_text(facts.valid_from),
        "effects": [dict(effect) for effect in facts.effects],
        "inputs": dict(facts.inputs),
        "previous": previous,
    }
    may_lack = {
        **{name: getattr(facts, name) for name in ("status_reason", "operator", "verdict")},
        **{name: dict(getattr(facts, name)) for name in _MAPPINGS},
        **{name: [dict(entry) for entry in getattr(facts, name)] for name in ("judged", "references")},
        "valid_until": facts.valid_until and utc_text(facts.valid_until),
        "temperature_range_c": facts.temperature_range_c and list(facts.temperature_range_c),
        "accelerometer": solution.accelerometer and _triad(solution.accelerometer),
        "gyroscope": solution.gyroscope and _triad(solution.gyroscope),
    }
    document |= {name: value for name, value in may_lack.items() if value}
    if facts.verdict is not None:
        document["limits"] = [
            {key: value for key, value in asdict(limit).items() if value is not None} for limit in facts.limits
        ]
    if solution.reference_temperature is not None:
        document["reference_temperature_c"] = solution.reference_temperature
    if (covariance := _covariance(solution)) is not None:
        document["covariance"] = covariance
    return document


def _covariance(solution: Solution) -> dict[str, Any] | None:
    """Return names and matrix of what is applied, each in the products of its units; None if it is not finite."""
    rows = [i for i, name in enumerate(solution.names) if name.split(".")[0] in TRIADS]
    matrix = solution.covariance[np.ix_(rows, rows)] if rows else np.empty((0, 0))
    if not rows or not np.isfinite(matrix).all():
        return None
    return {"names": [solution.names[i] for i in rows], "matrix": matrix.tolist()}


def _triad(triad: TriadCalibration) -> dict[str, Any]:
    estimates = {name: getattr(triad, name) for name in ("scale_factor", "misalignment", "bias")}
    return {
        name: {"value": one.value.tolist(), "std": one.std.tolist(), "unit": one.unit}
        for name, one in estimates.items()
    }


def accept_calibration(
    session: Session,
    solution: Solution,
    facts: CalibrationFacts,
    *,
    campaign_folder: str | None = None,
) -> CalibrationRow:
    """Append a solution as calibration/1, chained to the newest calibration of the whole database.

    Call it in `fixtures_db.database.Database.write`, whose lock keeps two stations from chaining to one row.

    Raises
    ------
    AlreadyStored
        If one of the same campaign with the same numbers from the same files is there.
    LimitsChanged
        If its verdict is against other limits than the model has now.
    """
    if facts.verdict is not None and facts.limits != limits_of(session, facts.model):
        raise LimitsChanged(facts.model)
    previous = newest_hash(session, CalibrationRow)
    document = calibration_document(solution, facts, previous)
    if campaign_folder is not None:
        _refuse_again(session, campaign_folder, document)
        document["manifest"] = campaign(session, campaign_folder).manifest_sha256  # ties it to the accepted steps
    unit = imu(session, facts.model, facts.serial)
    campaign_id = None if campaign_folder is None else campaign(session, campaign_folder).id
    session.flush()  # so that the journal's head is that of the rows used
    document |= grounds_now(session, facts, campaign_id)
    row = CalibrationRow(
        imu=unit, campaign_id=campaign_id, accepted_utc=facts.accepted_utc, code_version=facts.software,
        inputs=dict(facts.inputs), document=canonical(document),
    )  # fmt: skip
    return chained(session, row)


def grounds_now(session: Session, facts: CalibrationFacts, campaign_id: int | None) -> dict[str, Any]:
    """Return what a calibration says of the rows that it rests on: the journal's head, a hash of each kind."""
    used = used_now(session, facts.model, facts.serial, campaign_id)
    return {"journal": journal_head(session)._asdict(), "used": used}


def _refuse_again(session: Session, folder: str, document: dict[str, Any]) -> None:
    of_campaign = select(CalibrationRow).where(CalibrationRow.campaign_id == campaign(session, folder).id)
    for row in session.scalars(of_campaign):
        stored = json.loads(row.document)
        if all(stored.get(part) == document.get(part) for part in ("accelerometer", "gyroscope", "inputs")):
            raise AlreadyStored(folder, row.sha256)


def history(session: Session, serial: str) -> Sequence[CalibrationRow]:
    """Return the calibrations of every IMU of a serial number, oldest first; ``row.document`` is calibration/1."""
    of_unit = select(CalibrationRow).join(ImuRow).where(ImuRow.serial == serial)
    return session.scalars(of_unit.order_by(CalibrationRow.id)).all()


def calibration(session: Session, sha256: str) -> CalibrationRow:
    """Return a calibration by its hash; raise `NotInDatabase` if there is none."""
    row = session.scalars(select(CalibrationRow).where(CalibrationRow.sha256 == sha256)).first()
    if row is None:
        raise NotInDatabase("calibration", sha256)
    return row


def calibrations_like(session: Session, prefix: str) -> Sequence[CalibrationRow]:
    """Return the calibrations whose hash begins with ``prefix``, oldest first."""
    rows = select(CalibrationRow).where(CalibrationRow.sha256.startswith(prefix, autoescape=True))
    return session.scalars(rows.order_by(CalibrationRow.id)).all()


def calibration_before(session: Session, row: CalibrationRow) -> CalibrationRow | None:
    """Return the calibration of the same IMU that ``row`` took the place of, None if it is the first.

    Others of the same campaign, solved again, do not count.
    """
    rows = select(CalibrationRow).where(CalibrationRow.imu_id == row.imu_id, CalibrationRow.id < row.id)
    return _newest(session, rows, row.campaign_id)


def last_calibration(
    session: Session, model: str, serial: str, but_of: str | None = None
) -> CalibrationRow | None:
    """Return the newest calibration of an IMU, None if it has none; those of campaign ``but_of`` do not count."""
    rows = select(CalibrationRow).join(ImuRow).where(ImuRow.model == model, ImuRow.serial == serial)
    own = None if but_of is None else known_campaign(session, but_of)
    return _newest(session, rows, None if own is None else own.id)


def newest_calibration(session: Session, folder: str) -> CalibrationRow | None:
    """Return the newest calibration stored from the campaign of a folder, None if there is none."""
    return _newest(session, select(CalibrationRow).join(CampaignRow).where(CampaignRow.folder == folder))


def _newest(session: Session, rows: Select[CalibrationRow], but_of: int | None = None) -> CalibrationRow | None:
    if but_of is not None:
        rows = rows.where(CalibrationRow.campaign_id.is_distinct_from(but_of))
    return session.scalars(rows.order_by(CalibrationRow.id.desc()).limit(1)).first()


def calibrated_serials(session: Session) -> Sequence[str]:
    """Return the serial numbers that have a calibration."""
    return session.scalars(select(ImuRow.serial).join(CalibrationRow).distinct().order_by(ImuRow.serial)).all()


def verify_chain(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every calibration that was altered, dropped or reordered since it was accepted; empty if none was.

    Rows dropped at the newest end show only against ``expected_head``, a head hash that was kept elsewhere
    (printed on a report): it must be the hash of some row.
    """
    return verify_rows(session, CalibrationRow, expected_head, _column_fault)


def _column_fault(row: CalibrationRow) -> list[ChainFault]:
    try:
        document = json.loads(row.document)
    except ValueError:
        return [ChainFault(f"calibration {row.id}", "a document that is not JSON", "calibration/1")]
    if (fault := _campaign_fault(row, document)) is not None:
        return [fault]
    unit: ImuRow | None = row.imu  # whoever alters a row is held by no foreign key
    found = {
        "serial": unit and unit.serial,
        "model": unit and unit.model,
        "software": row.code_version,
        "inputs": row.inputs,
        "previous": row.previous,
        "accepted_utc": utc_text(row.accepted_utc),
    }
    for key, value in found.items():
        if value != (expected := _get(document, key)):
            return [ChainFault(f"calibration {row.id}", f"{key} column {value!r}", repr(expected))]
    return []


def _campaign_fault(row: CalibrationRow, document: Any) -> ChainFault | None:
    """Return what is wrong with a calibration's campaign: its steps must be those it was made from."""
    kept, campaign = _get(document, "manifest"), row.campaign
    if campaign is None:
        is_right, stated = kept is None and row.campaign_id is None, "no campaign"
    elif kept is None:  # stored before calibrations named a manifest
        inputs = (_get(document, "inputs") or {}).values()
        is_right, stated = any(step.sha256 in inputs for step in campaign.steps), f"campaign {campaign.folder}"
    else:
        is_right, stated = kept in manifest_heads(campaign.steps), f"campaign {campaign.folder} as it is"
    return None if is_right else ChainFault(f"calibration {row.id}", stated, f"that of manifest {kept or 'none'}")


def _get(document: Any, key: str) -> Any:
    return document.get(key) if isinstance(document, dict) else None


MADE_WITH = ("cube", "slab", "site", "operator")  # what may shift a calibration, except the unit


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
    stated = document.get("procedure", {}).get("ended_utc")
    return accepted if stated is None else datetime.fromisoformat(stated).astimezone(UTC)


def _made_with(document: dict[str, Any], campaign: CampaignRow | None) -> dict[str, str]:
    found = {kind: getattr(campaign, f"{kind}_id", None) for kind in MADE_WITH[:3]}
    found |= {one["kind"]: one.get("id") for one in document.get("references", ())}
    found["site"] = document.get("site", {}).get("id", found["site"])
    found["operator"] = document.get("operator")
    return {kind: name for kind in MADE_WITH if (name := found.get(kind))}
