"""What a campaign was measured with: cube, slab and site, each with the certificate that held for it then."""

from collections.abc import Sequence
from datetime import date, datetime
from typing import Any

from sqlalchemy.orm import Session

from fixtures_db.calibration import utc_text
from fixtures_db.campaigns import known_campaign, last_accepted
from fixtures_db.chained import Measured, in_force
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
    until, found = last_accepted(row), list[dict[str, Any]]()
    if cube := row.cube_id and session.get(CubeRow, row.cube_id):
        found.append({"kind": "cube", "id": cube.id, "side_mm": cube.side_mm, **_of_cube(cube, until)})
    if slab := row.slab_id and session.get(SlabRow, row.slab_id):
        level = in_force(_until(slab.levels, until))
        said = _dates(slab.certificate_date, slab.due_date) if level is None else _certified([level])
        found.append({"kind": "slab", "id": slab.id, **said})
    if site := row.site_id and session.get(SiteRow, row.site_id):
        source = {} if site.gravity_source is None else {"source": site.gravity_source}
        found.append({"kind": "site", "id": site.id, **source, **_dates(site.gravity_date, site.due_date)})
    return found


def _of_cube(cube: CubeRow, until: datetime) -> dict[str, Any]:
    faces: dict[str, list[FaceCertificateRow]] = {}
    for row in _until(cube.certificates, until):
        faces.setdefault(row.resting, []).append(row)
    if faces:
        return _certified([last for rows in faces.values() if (last := in_force(rows)) is not None])
    if (measured := in_force(_until(cube.measurements, until))) is not None:
        return _certified([measured])
    return _dates(cube.certificate_date, cube.due_date)


def _until(rows: Sequence[Measured], until: datetime) -> list[Measured]:
    return [row for row in rows if row.measured_utc <= until]


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
