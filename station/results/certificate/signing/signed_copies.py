"""Files of an issued certificate, signed: held against their own signature, and recorded."""

import hashlib
from pathlib import Path

from cryptography.hazmat.primitives import hashes

from fixtures_db.database import Database
from fixtures_db.issued_certificates import record_signed
from station.files.xml_document import parse_xml
from station.results.certificate.signing.pdf_signature import open_pdf, sign_pdf, verified_pdf
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.xml_signature import sign_xml, verified_xml


def signed_copy(
    database: Database, number: str, path: Path, content: bytes, key: SigningKey, time_service: str | None
) -> bytes:
    """Return the XML or PDF of a certificate signed, for ``path``, whose ending says which it is.

    Raises
    ------
    DataRefused
        If it cannot be signed, or is signed already.
    NoTimeStamp
        If the service gives none.
    """
    kind = path.suffix.removeprefix(".")
    if kind == "pdf":
        signed = sign_pdf(content, key, time_service)
        verified_pdf(signed, open_pdf(signed))
    else:
        signed = sign_xml(content, key, time_service)
        verified_xml(parse_xml(signed, path))
    sha256 = hashlib.sha256(signed).hexdigest()
    with database.write() as session:
        record_signed(session, number, kind, sha256, key.certificate.fingerprint(hashes.SHA256()).hex())
    return signed
