"""What a campaign was measured with: cube, slab and site, each with the certificate that held for it then."""

from collections.abc import Mapping, Sequence
from datetime import date, datetime
from typing import Any

from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import owners_rows_in_force
from fixtures_db.calibration import utc_text
from fixtures_db.campaigns import is_expired, known_campaign, last_accepted
from fixtures_db.schema import CubeMeasurementRow, CubeRow, FaceCertificateRow, SiteRow, SlabLevelRow, SlabRow

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
    said = {
        "certificate": newest.sha256,
        "source": "; ".join(sources),
        "measured_utc": utc_text(newest.measured_utc),
    }
    return said | _dates(None, min(due, default=None))


def _dates(measured: date | None, due: date | None) -> dict[str, Any]:
    named = {"measured_utc": measured, "due_date": due}
    return {name: value.isoformat() for name, value in named.items() if value is not None}
