"""One number of a laboratory is taken in once; again only to say the due date that was not said."""

from pathlib import Path

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.schema import FaceCertificateRow, SlabLevelRow
from station.errors import DataRefused
from station.results.fixture_certificate.fixture_document import FixtureDocument
from station.results.fixture_certificate.quantity_names import SLAB

Values = dict[str, tuple[object, ...]]


def refuse_known(session: Session, read: FixtureDocument, where: str | Path) -> None:
    """Raise `DataRefused` if a laboratory's number is there with other values, or adds nothing."""
    begins = f"{read.laboratory}, certificate No. {read.number}, "
    faces = session.scalars(
        select(FaceCertificateRow).where(FaceCertificateRow.source.startswith(begins, autoescape=True))
    ).all()
    levels = session.scalars(
        select(SlabLevelRow).where(SlabLevelRow.source.startswith(begins, autoescape=True))
    ).all()
    if not faces and not levels:
        return
    stored: Values = {row.resting: _of_face(row) for row in faces}
    if levels:
        stored[SLAB] = _of_level(levels[-1])
    if stored != _of_document(read):
        found = f"No. {read.number}, which is in the database with other values"
        raise DataRefused(where, None, found, "the same, or a new number", "ask the laboratory which is valid")
    dues = {*(row.due_date for row in faces), *(row.due_date for row in levels)} - {None}
    if read.due is None or read.due in dues:
        raise DataRefused(
            where, None, f"No. {read.number}, which is in the database", "a new one", "nothing to do"
        )
    if dues:
        found = f"No. {read.number}, which is in the database as due {max(filter(None, dues))}"
        raise DataRefused(where, None, found, "that day", "the imported entry stays unchanged")


def _of_document(read: FixtureDocument) -> Values:
    values = Values()
    for part, tilt in read.tilts.items():
        (a, b), C = tilt.value.tolist(), tilt.covariance
        spread = (C[0, 0] ** 0.5, C[1, 1] ** 0.5) if part == SLAB else (C[0, 0], C[0, 1], C[1, 1])
        values[part] = (read.measured, a, b, *map(float, spread))
    return values


def _of_face(row: FaceCertificateRow) -> tuple[object, ...]:
    covariance = (row.covariance_11_rad2, row.covariance_12_rad2, row.covariance_22_rad2)
    return (row.measured_utc.date(), row.up_tilt_1_rad, row.up_tilt_2_rad, *covariance)


def _of_level(row: SlabLevelRow) -> tuple[object, ...]:
    return (row.measured_utc.date(), row.tilt_east_rad, row.tilt_north_rad, row.std_east_rad, row.std_north_rad)
