"""Certificates of a cube's resting faces, and the cube as a solve takes it."""

from collections.abc import Mapping
from datetime import date, datetime

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import append, date_owner, in_force
from fixtures_db.cube_measurements import measurement
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow, FaceCertificateRow
from fixtures_db.slab_levels import MAX_TILT_RAD
from procedures.arrays import FloatArray
from procedures.campaign.campaign import FaceCertificate, Fixture
from procedures.frames import FACES


def certify_faces(
    session: Session,
    cube_id: str,
    faces: Mapping[str, FaceCertificate],
    *,
    source: str,
    measured_utc: datetime,
    due_date: date | None = None,
) -> None:
    """Append a certificate of some or all faces of a cube; those measured earlier stay and are no longer used.

    ``faces`` by resting face (``x_up`` ...): up vector's components (2,) [rad] along the two other cube axes
    and their covariance (2, 2) [rad2]. ``source`` says who measured, and how.
    """
    cube = fixture_row(session, CubeRow, cube_id)
    for resting, face in faces.items():
        row = FaceCertificateRow(
            cube_id=cube_id,
            resting=resting,
            source=source,
            measured_utc=measured_utc,
            due_date=due_date,
            **_columns(face),
        )
        check_certificate(row)
        append(session, row)
    date_owner(session, cube)


def cube(session: Session, cube_id: str, C_sb: FloatArray | None = None) -> Fixture:
    """Return the fixture a solve takes: of each face what was measured last, none where it never was.

    Where no face was, it holds what IMUs measured of the cube last. ``C_sb`` (3, 3), a rotation, takes the cube's
    axes to the IMU's; identity if not given.
    """
    row = fixture_row(session, CubeRow, cube_id)
    faces = {resting: face_certificate(face) for resting, face in faces_in_force(row).items()}
    last = None if faces else in_force(row.measurements)
    measured = None if last is None else measurement(last).cube
    return Fixture(faces, np.eye(3) if C_sb is None else C_sb, cube_id, measured)


def faces_in_force(cube: CubeRow) -> dict[str, FaceCertificateRow]:
    """Return by resting face what was measured last, in the order of `FACES`."""
    by_face = {resting: [row for row in cube.certificates if row.resting == resting] for resting in FACES}
    return {resting: row for resting, rows in by_face.items() if (row := in_force(rows)) is not None}


def check_certificate(row: FaceCertificateRow) -> None:
    """Raise `ValueError` if a row is no certificate of a face."""
    if row.resting not in FACES:
        raise ValueError(f"face {row.resting!r} is none of {', '.join(FACES)}")
    _columns(face_certificate(row))


def _columns(face: FaceCertificate) -> dict[str, float]:
    covariance = np.asarray(face.covariance, dtype=float)
    if (
        covariance.shape != (2, 2)
        or not np.allclose(covariance, covariance.T)
        or np.linalg.eigvalsh(covariance)[0] < 0
    ):
        raise ValueError(
            f"covariance of a face is {covariance.tolist()}, expected symmetric (2, 2), none negative"
        )
    if not np.all(np.abs(face.up_tilt) < MAX_TILT_RAD):
        raise ValueError(f"tilt of a face is {face.up_tilt} rad, expected each under {MAX_TILT_RAD} rad")
    return {
        "up_tilt_1_rad": float(face.up_tilt[0]),
        "up_tilt_2_rad": float(face.up_tilt[1]),
        "covariance_11_rad2": float(covariance[0, 0]),
        "covariance_12_rad2": float(covariance[0, 1]),
        "covariance_22_rad2": float(covariance[1, 1]),
    }


def face_certificate(row: FaceCertificateRow) -> FaceCertificate:
    """Return a row as a solve takes it."""
    covariance = [
        [row.covariance_11_rad2, row.covariance_12_rad2],
        [row.covariance_12_rad2, row.covariance_22_rad2],
    ]
    return FaceCertificate(np.array([row.up_tilt_1_rad, row.up_tilt_2_rad]), np.array(covariance))
