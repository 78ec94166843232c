"""Cubes: what the drawing allows, what was measured, and the fixture a solve takes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.chain import GENESIS, ChainFault, Link, canonical, digest, faults
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.schema import CubeRow, FaceCertificateRow, ToleranceRow
from procedures.arrays import FloatArray
from procedures.campaign import FaceCertificate, Fixture
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


def cubes(session: Session) -> Sequence[CubeRow]:
    """Return all cubes by name."""
    return session.scalars(select(CubeRow).order_by(CubeRow.id)).all()


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
    """Append a certificate of some or all faces of a cube; older ones stay and are no longer used.

    ``faces`` by resting face (``x_up`` ...): up vector's components (2,) [rad] along the two other cube axes
    and their covariance (2, 2) [rad2]. ``source`` says who measured, and how.
    """
    cube = cube_row(session, cube_id)
    head = session.scalars(
        select(FaceCertificateRow.sha256).order_by(FaceCertificateRow.id.desc()).limit(1)
    ).first()
    for resting, face in faces.items():
        if resting not in FACES:
            raise ValueError(f"face {resting!r} is none of {', '.join(FACES)}")
        row = FaceCertificateRow(
            cube_id=cube_id,
            resting=resting,
            source=source,
            measured_utc=measured_utc.astimezone(UTC),
            due_date=due_date,
            previous=head or GENESIS,
            **_columns(face),
        )
        head = row.sha256 = digest(_text(row))
        session.add(row)
        session.flush()
    cube.certificate_date, cube.due_date = measured_utc.date(), due_date
    session.flush()
    session.expire(cube, ["certificates"])


def cube(session: Session, cube_id: str, C_ib: FloatArray | None = None) -> Fixture:
    """Return the fixture a solve takes: of each face the newest certificate, none where it was never measured.

    ``C_ib`` (3, 3) takes the cube's axes to the IMU's; identity if not given.
    """
    newest = {row.resting: row for row in cube_row(session, cube_id).certificates}
    faces = {resting: _certificate(newest[resting]) for resting in FACES if resting in newest}
    return Fixture(faces, np.eye(3) if C_ib is None else C_ib, cube_id)


def verify_certificates(session: Session) -> list[ChainFault]:
    """Return every face certificate that was altered, dropped or reordered since it was stored."""
    rows = session.scalars(select(FaceCertificateRow).order_by(FaceCertificateRow.id))
    return faults(Link(f"face certificate {row.id}", _text(row), row.previous, row.sha256) for row in rows)


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


def _certificate(row: FaceCertificateRow) -> FaceCertificate:
    covariance = [
        [row.covariance_11_rad2, row.covariance_12_rad2],
        [row.covariance_12_rad2, row.covariance_22_rad2],
    ]
    return FaceCertificate(np.array([row.up_tilt_1_rad, row.up_tilt_2_rad]), np.array(covariance))


def _text(row: FaceCertificateRow) -> str:
    hashed = {
        column.key: getattr(row, column.key)
        for column in FaceCertificateRow.__table__.columns
        if column.key not in {"id", "sha256"}
    }
    return canonical(
        {key: value.isoformat() if isinstance(value, date) else value for key, value in hashed.items()}
    )
