"""Cubes as IMUs measured them: appended, chained, and used where the faces have no certificate."""

import json
from collections.abc import Mapping, Sequence
from datetime import date, datetime
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import append, date_owner
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeMeasurementRow, CubeRow
from fixtures_db.slab_levels import MAX_TILT_RAD
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import NAMES, CubeMeasurement, UnitShare


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
    cube = fixture_row(session, CubeRow, cube_id)
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


def measurement(row: CubeMeasurementRow) -> CubeMeasurement:
    """Return a row as it was measured; raise `ValueError` if it is no measurement."""
    try:
        values, covariance, sources = (json.loads(t) for t in (row.values_rad, row.covariance_rad2, row.sources))
        names, value = tuple(values), np.array(list(values.values()), dtype=float)
        shares = tuple(_share(source, len(names)) for source in sources)
        units = tuple(share.unit for share in shares)
        cube = MeasuredCube(names, value, np.array(covariance, dtype=float), units)
        quadratic = (s.quadratic_std**2 * s.by_quadratic @ s.by_quadratic.T for s in shares)
        return CubeMeasurement(cube, cube.covariance - sum(quadratic, np.zeros(cube.covariance.shape)), shares)
    except (TypeError, KeyError, AttributeError, ValueError) as error:
        raise ValueError(f"measurement of cube {row.cube_id!r}: {error}") from error


def check_measurement(row: CubeMeasurementRow) -> None:
    """Raise `ValueError` if a row is no measurement of a cube."""
    cube, name = measurement(row).cube, f"measurement of cube {row.cube_id!r}"
    n, C = len(cube.names), cube.covariance
    if not n or not set(cube.names) <= set(NAMES):
        raise ValueError(f"{name}: values {', '.join(cube.names)}, expected of {', '.join(NAMES)}")
    if not np.all(np.abs(cube.value) < MAX_TILT_RAD):
        raise ValueError(f"{name}: values {cube.value.tolist()} rad, expected each under {MAX_TILT_RAD} rad")
    if C.shape != (n, n) or not np.allclose(C, C.T, rtol=1e-9, atol=0) or not np.linalg.eigvalsh(C)[0] > 0:
        raise ValueError(f"{name}: covariance, expected symmetric ({n}, {n}), positive definite")


def _share(source: Mapping[str, Any], n: int) -> UnitShare:
    left, by = (np.array(source[key], dtype=float) for key in ("quadratic_left", "by_quadratic"))
    if by.shape != (n, 3) or left.shape != (3,):
        raise ValueError(f"by_quadratic is {by.shape} and quadratic_left {left.shape}, expected ({n}, 3) and (3,)")
    return UnitShare(str(source["unit"]), by, float(source["quadratic_std"]), left)


def _text(value: object) -> str:
    # the order of the values is that of the covariance: keys are not sorted
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
