"""Cubes: what the drawing allows, what was measured, and the fixture a solve takes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime

import numpy as np
from sqlalchemy.orm import Session

from fixtures_db.chain import ChainFault
from fixtures_db.chained import append, date_owner, in_force, verify_rows
from fixtures_db.cubes_known import cubes
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.measured_rows import measurement
from fixtures_db.schema import CubeRow, FaceCertificateRow, ToleranceRow
from procedures.arrays import FloatArray
from procedures.campaign.campaign import FaceCertificate, Fixture
from procedures.frames import FACES


@dataclass(frozen=True, slots=True)
class Tolerance:
    """An item of a cube's drawing: flatness, perpendicularity or parallelism of a face, in mm over its side."""

    item: str
    kind: str
    face: str
    reference_face: str | None
    tolerance_mm: float


def add_cube(
    session: Session,
    cube_id: str,
    *,
    side_mm: float,
    tolerances: Sequence[Tolerance] = (),
    certificate_date: date | None = None,
    due_date: date | None = None,
) -> CubeRow:
    """Add a cube with the tolerance items of its drawing; raise `AlreadyThere` if the name is taken."""
    if session.get(CubeRow, cube_id) is not None:
        raise AlreadyThere("cube", cube_id)
    if not side_mm > 0:
        raise ValueError(f"side of cube {cube_id!r} is {side_mm} mm, expected a positive length")
    row = CubeRow(id=cube_id, side_mm=side_mm, certificate_date=certificate_date, due_date=due_date)
    row.tolerances = [
        ToleranceRow(
            item=t.item, kind=t.kind, face=t.face, reference_face=t.reference_face, tolerance_mm=t.tolerance_mm
        )
        for t in tolerances
    ]
    session.add(row)
    session.flush()
    return row


def cube_row(session: Session, cube_id: str) -> CubeRow:
    """Return one cube's row; raise `NotInDatabase` if there is none of that name."""
    if (row := session.get(CubeRow, cube_id)) is None:
        raise NotInDatabase("cube", cube_id, [known.id for known in cubes(session)])
    return row


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
    cube = cube_row(session, cube_id)
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

    Where no face was, it holds what IMUs measured of the cube last. ``C_sb`` (3, 3) takes the cube's axes to the
    IMU's; identity if not given.
    """
    row = cube_row(session, cube_id)
    faces = {resting: face_certificate(face) for resting, face in faces_in_force(row).items()}
    last = None if faces else in_force(row.measurements)
    measured = None if last is None else measurement(last).cube
    return Fixture(faces, np.eye(3) if C_sb is None else C_sb, cube_id, measured)


def faces_in_force(cube: CubeRow) -> dict[str, FaceCertificateRow]:
    """Return by resting face what was measured last, in the order of `FACES`."""
    by_face = {resting: [row for row in cube.certificates if row.resting == resting] for resting in FACES}
    return {resting: row for resting, rows in by_face.items() if (row := in_force(rows)) is not None}


def verify_certificates(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every face certificate that was altered, dropped or reordered since it was stored."""
    return verify_rows(session, FaceCertificateRow, "face certificate", expected_head)


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
