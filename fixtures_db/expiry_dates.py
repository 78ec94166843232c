"""What expires, and when: certificates of cubes and slabs, surveys of sites, calibrations of IMUs."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date, datetime

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from fixtures_db.fixtures import KIND_NAMES, fixture_rows
from fixtures_db.schema import CalibrationRow


@dataclass(frozen=True, slots=True, order=True)
class Due:
    """Something whose certificate, survey or calibration holds until the end of ``date``."""

    date: date
    kind: str
    name: str


def due(session: Session, until: date) -> list[Due]:
    """Return what has expired or does so by the day ``until``, the earliest first."""
    return sorted(one for one in _all(session) if one.date <= until)


def _all(session: Session) -> Iterator[Due]:
    for kind, word in KIND_NAMES.items():
        rows = fixture_rows(session, kind)
        yield from (Due(row.due_date, word, row.id) for row in rows if row.due_date is not None)
    newest = select(func.max(CalibrationRow.id)).group_by(CalibrationRow.imu_id)
    for row in session.scalars(select(CalibrationRow).where(CalibrationRow.id.in_(newest))):
        until = json.loads(row.document).get("valid_until")
        if until is not None:
            yield Due(datetime.fromisoformat(until).date(), "imu", f"{row.imu.model} {row.imu.serial}")
