"""Certificates as they were handed out: whole, numbered, each naming the hash of the one before it; signed files.

The row holds the certificate itself. What is on paper or in a file is a copy: it can be made again, and
distinguished from one that was altered or never issued. Of a signed file the row holds the hash of all of its
bytes.
"""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, chained, verify_rows
from fixtures_db.errors import NotInDatabase
from fixtures_db.hash_chain import ChainFault, digest
from fixtures_db.schema import CalibrationRow, IssuedCertificateRow, SignedFileRow


def next_number(session: Session, prefix: str, year: int) -> str:
    """Return the number that the next certificate has: prefix, year and how manieth of this database it is."""
    count = session.scalar(select(func.count()).select_from(IssuedCertificateRow)) or 0
    return f"{prefix}{year}-{count + 1:04d}"


def record_issue(session: Session, row: IssuedCertificateRow) -> IssuedCertificateRow:
    """Append a certificate and give it its hashes; call it in the `Database.write` that gave it its number."""
    row.html_sha256, row.dcc_sha256 = digest(row.html), None if row.dcc is None else digest(row.dcc)
    return chained(session, row)


def issued_of(session: Session, calibration_sha256: str) -> Sequence[IssuedCertificateRow]:
    """Return the certificates of a calibration, the first one first; the last is the one in force."""
    rows = select(IssuedCertificateRow).where(IssuedCertificateRow.calibration_sha256 == calibration_sha256)
    return session.scalars(rows.order_by(IssuedCertificateRow.id)).all()


def issued_as(session: Session, sha256: str) -> IssuedCertificateRow:
    """Return the certificate whose HTML or XML has a hash; raise `NotInDatabase` if none was issued."""
    has = (IssuedCertificateRow.html_sha256 == sha256) | (IssuedCertificateRow.dcc_sha256 == sha256)
    if (row := session.scalars(select(IssuedCertificateRow).where(has)).first()) is None:
        raise NotInDatabase(ROW_TITLES[IssuedCertificateRow], sha256)
    return row


def verify_issued(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every certificate that was altered, dropped or reordered since, or is of no calibration.

    Rows dropped at the newest end show only against ``expected_head``, a hash that was kept elsewhere.
    """
    known = set(session.scalars(select(CalibrationRow.sha256)))

    def others(row: IssuedCertificateRow) -> Iterator[ChainFault]:
        name = f"{ROW_TITLES[IssuedCertificateRow]} {row.id}"
        if (actual := digest(row.html)) != row.html_sha256:
            yield ChainFault(name, f"html with sha256 {actual}", row.html_sha256)
        if (written := None if row.dcc is None else digest(row.dcc)) != row.dcc_sha256:
            yield ChainFault(name, f"XML with sha256 {written}", str(row.dcc_sha256))
        if row.calibration_sha256 not in known:
            yield ChainFault(name, "no such calibration", row.calibration_sha256)

    return verify_rows(session, IssuedCertificateRow, expected_head, others)


def record_signed(session: Session, number: str, kind: str, file_sha256: str, key_sha256: str) -> SignedFileRow:
    """Append a signed file of a certificate; call it in `fixtures_db.database.Database.write`."""
    now = datetime.now(UTC).replace(microsecond=0)
    return chained(session, SignedFileRow(number=number, kind=kind, file_sha256=file_sha256, key_sha256=key_sha256,
                                          signed_utc=now))  # fmt: skip


def signed_as(session: Session, file_sha256: str) -> SignedFileRow | None:
    """Return the signed file whose bytes have a hash, None if none has."""
    return session.scalars(select(SignedFileRow).where(SignedFileRow.file_sha256 == file_sha256)).first()


def issued_numbered(session: Session, number: str) -> IssuedCertificateRow | None:
    """Return the certificate of a number, None if none was issued."""
    return session.scalars(select(IssuedCertificateRow).where(IssuedCertificateRow.number == number)).first()
