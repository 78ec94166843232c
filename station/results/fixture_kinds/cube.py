"""A cube as it is shown: side and drawing in mm, certified tilts in arcsec."""

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.fixture_measurements import faces_in_force
from fixtures_db.fixtures import fixture_row, fixture_rows
from fixtures_db.schema import CubeRow, FaceCertificateRow
from procedures.units import RAD_PER_ARCSEC
from station.results.fixture_kinds import due_text


def lines(session: Session) -> list[str]:
    """Return a line for each cube."""
    return [
        f"{row.id}: {row.side_mm:g} mm, {len(faces_in_force(row))} of 6 faces certified, "
        f"{_by_imus(row)}{due_text(row)}"
        for row in fixture_rows(session, CubeRow)
    ]


def description(session: Session, name: str) -> str:
    """Return the drawing, of each face the certificate in force, and what IMUs measured, with the cube's drift.

    Raise `NotInDatabase` if there is no cube of that name.
    """
    row = fixture_row(session, CubeRow, name)
    of = _by_imus(row) or f"certificate {row.certificate_date or 'none'}, "
    said = [f"{row.id}: side {row.side_mm:g} mm, {of}{due_text(row)}"]
    said += _drawing(row)
    said += [f"  {resting}: {_face(face)}" for resting, face in faces_in_force(row).items()]
    earlier = len(row.certificates) - len(faces_in_force(row))
    said += [f"  and {earlier} earlier certificates of a face"] if earlier else []
    return "\n".join([*said, *(_measured(session, row) if row.measurements else [])])


def _by_imus(row: CubeRow) -> str:
    """Say when IMUs measured the cube, where its dates are theirs: no face has a certificate."""
    return "" if row.certificates or not row.measurements else f"measured by IMUs {row.certificate_date}, "


def _measured(session: Session, row: CubeRow) -> list[str]:
    from station.results.cube_measurement.known_faces import known_of  # scipy: only where a cube was measured
    from station.results.cube_measurement.measured_cube_text import known_lines, values

    known = known_of(session, row.id)
    at, last, _ = known.measured[-1]
    return [f"measured by {', '.join(last.cube.units)}, {at:%Y-%m-%d}", *values(last), *known_lines(known)]


def _drawing(row: CubeRow) -> list[str]:
    lines = list[str]()
    for t in row.tolerances:
        against = f" to {t.reference_face}" if t.reference_face else ""
        lines.append(f"  {t.item}: {t.kind} of {t.face}{against} {t.tolerance_mm:g} mm")
    return lines


def _face(row: FaceCertificateRow) -> str:
    tilts = (row.up_tilt_1_rad, row.covariance_11_rad2), (row.up_tilt_2_rad, row.covariance_22_rad2)
    said = ", ".join(
        f"{tilt / RAD_PER_ARCSEC:+z.2f} +- {np.sqrt(variance) / RAD_PER_ARCSEC:.2f}" for tilt, variance in tilts
    )
    return f"up tilt {said} arcsec ({row.source}, {row.measured_utc:%Y-%m-%d})"
