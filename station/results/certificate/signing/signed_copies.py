"""Files of an issued certificate, signed: held against their own signature, recorded, then put in their place."""

import hashlib
from pathlib import Path

from cryptography.hazmat.primitives import hashes

from fixtures_db.database import Database
from fixtures_db.signed_files import record_signed
from station.files.atomic_file import replace_file
from station.files.xml_document import parse_xml, read_document
from station.results.certificate.signing.pdf_signature import sign_pdf
from station.results.certificate.signing.pdf_verification import open_pdf, verified_pdf
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.xml_signature import sign_xml
from station.results.certificate.signing.xml_verification import verified_xml


def sign_file(database: Database, number: str, path: Path, key: SigningKey, time_service: str | None) -> str:
    """Sign the XML or PDF of a certificate where it stands and return the SHA-256 of the signed file.

    Raises
    ------
    DataRefused
        If it cannot be signed, or is signed already.
    NoTimeStamp
        If the service gives none; the file stays as it is.
    """
    content, kind = read_document(path), path.suffix.removeprefix(".")
    if kind == "pdf":
        signed = sign_pdf(content, key, time_service)
        verified_pdf(signed, open_pdf(signed))
    else:
        signed = sign_xml(content, key, time_service)
        verified_xml(parse_xml(signed, path))
    sha256 = hashlib.sha256(signed).hexdigest()
    with database.write() as session:
        record_signed(session, number, kind, sha256, key.certificate.fingerprint(hashes.SHA256()).hex())
    replace_file(path, signed)
    return sha256
