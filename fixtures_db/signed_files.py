"""Signed files of certificates: what was handed out, by the hash of all of its bytes."""

from datetime import UTC, datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import newest_hash, row_text
from fixtures_db.hash_chain import digest
from fixtures_db.schema import IssuedCertificateRow, SignedFileRow


def record_signed(session: Session, number: str, kind: str, file_sha256: str, key_sha256: str) -> SignedFileRow:
    """Append a signed file of a certificate; call it in `fixtures_db.database.Database.write`."""
    row = SignedFileRow(
        number=number, kind=kind, file_sha256=file_sha256, key_sha256=key_sha256,
        signed_utc=datetime.now(UTC).replace(microsecond=0), previous=newest_hash(session, SignedFileRow),
    )  # fmt: skip
    row.sha256 = digest(row_text(row))
    session.add(row)
    session.flush()
    return row


def signed_as(session: Session, file_sha256: str) -> SignedFileRow | None:
    """Return the signed file whose bytes have a hash, None if none has."""
    return session.scalars(select(SignedFileRow).where(SignedFileRow.file_sha256 == file_sha256)).first()


def issued_numbered(session: Session, number: str) -> IssuedCertificateRow | None:
    """Return the certificate of a number, None if none was issued."""
    return session.scalars(select(IssuedCertificateRow).where(IssuedCertificateRow.number == number)).first()
