"""Cubes as IMUs measured them: appended, chained, and used where the faces have no certificate."""

import json
from collections.abc import Mapping, Sequence
from datetime import date, datetime

from sqlalchemy.orm import Session

from fixtures_db.chain import ChainFault
from fixtures_db.chained import append, date_owner, verify_rows
from fixtures_db.cubes import cube_row
from fixtures_db.measured_rows import check_measurement
from fixtures_db.schema import CubeMeasurementRow, CubeRow
from procedures.campaign.measured_cube import CubeMeasurement


def add_measurement(
    session: Session,
    cube_id: str,
    measured: CubeMeasurement,
    *,
    campaigns: Mapping[str, Mapping[str, str]],
    measured_utc: datetime,
    due_date: date | None = None,
) -> CubeMeasurementRow:
    """Append a measurement of a cube; those before it stay.

    ``campaigns`` holds by unit, model and serial number, the SHA-256 of each campaign by its folder's name.
    """
    cube = cube_row(session, cube_id)
    sources = [
        {
            "unit": share.unit,
            "campaigns": dict(campaigns[share.unit]),
            "by_quadratic": share.by_quadratic.tolist(),
            "quadratic_std": share.quadratic_std,
            "quadratic_left": share.quadratic_left.tolist(),
        }
        for share in measured.shares
    ]
    row = CubeMeasurementRow(
        cube_id=cube_id,
        values_rad=_text(dict(zip(measured.cube.names, measured.cube.value.tolist(), strict=True))),
        covariance_rad2=_text(measured.cube.covariance.tolist()),
        sources=_text(sources),
        measured_utc=measured_utc,
        due_date=due_date,
    )
    check_measurement(row)
    append(session, row)
    date_owner(session, cube)
    return row


def measurements(cube: CubeRow) -> Sequence[CubeMeasurementRow]:
    """Return a cube's measurements, the earliest first."""
    return sorted(cube.measurements, key=lambda row: (row.measured_utc, row.id))


def verify_measurements(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every measurement of a cube that was altered, dropped or reordered since it was stored."""
    return verify_rows(session, CubeMeasurementRow, "cube measurement", expected_head)


def _text(value: object) -> str:
    # the order of the values is that of the covariance: keys are not sorted
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
