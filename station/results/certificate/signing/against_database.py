"""A certificate's file held against the database that issued it: its bytes, the chain, the raw data's hashes."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import verify_rows
from fixtures_db.errors import NotInDatabase
from fixtures_db.issued_certificates import issued_numbered, issued_of, signed_as, verify_issued
from fixtures_db.schema import CalibrationRow, IssuedCertificateRow, SignedFileRow
from fixtures_db.stored_calibrations import calibration, verify_chain
from station.errors import DataRefused
from station.files.sha256sums import sha256_of
from station.files.xml_document import parse_xml
from station.results.certificate.signing.journal_witness import journal_finding
from station.results.certificate.signing.verification import PDF_MARK, UNSIGNED, Finding, Verified
from station.results.certificate.signing.xml_names import NAMESPACES, SCHEMA_LOCATION, dcc


def database_findings(session: Session, url: str, content: bytes, found: Verified) -> list[Finding]:
    """Return what a database says of a file; of one that it did not issue, that."""
    sha256 = hashlib.sha256(content).hexdigest()
    signed = signed_as(session, sha256)
    if signed is None and UNSIGNED in found.findings and content.startswith(PDF_MARK):
        words = "a PDF without signature is a copy, and its bytes are not recorded: verify the HTML or the XML"
        return [Finding("database", words, None)]
    number = signed.number if signed is not None else _number(found.document) or _stated_number(content)
    row = None if number is None else issued_numbered(session, number)
    if row is None:
        words = f"{url} has no certificate No. {number}" if number else f"not the bytes of any file in {url}"
        return [Finding("database", words, None)]
    said = [_bytes(session, row, signed, sha256), *_content(row, found.document), *_records(session, row)]
    return [*said, *journal_finding(session, found)]


def _number(document: Any) -> str | None:
    core = None if document is None else document.find(".//dcc:coreData/dcc:uniqueIdentifier", NAMESPACES)
    return None if core is None else str(core.text)


def _stated_number(content: bytes) -> str | None:
    """Return the number that an XML states, proven or not; None of a PDF, or where there is none."""
    try:
        return _number(parse_xml(content, "certificate"))
    except DataRefused:
        return None


def _bytes(session: Session, row: IssuedCertificateRow, signed: SignedFileRow | None, sha256: str) -> Finding:
    """Say whether each byte is as it was handed out."""
    newest = issued_of(session, row.calibration_sha256)[-1]
    since = "" if newest.id == row.id else f"; replaced since by No. {newest.number}"
    if signed is not None:
        faults = [one for one in verify_rows(session, SignedFileRow) if one.row == f"signed file {signed.id}"]
        day = f"{signed.signed_utc:%Y-%m-%d}"
        words = str(faults[0]) if faults else f"every byte as signed on {day}, certificate No. {row.number}{since}"
        return Finding("database", words, not faults)
    if sha256 == row.dcc_sha256:
        return Finding(
            "database", f"every byte as issued, certificate No. {row.number}, without signature{since}", True
        )
    return Finding(
        "database", f"not the bytes of any file of certificate No. {row.number} as recorded{since}", False
    )


def _content(row: IssuedCertificateRow, document: Any) -> Iterator[Finding]:
    """Say whether what is signed is what was issued."""
    if document is None or row.dcc is None:
        return
    same = _plain(document) == _plain(etree.fromstring(row.dcc.encode()))
    words = "as issued" if same else f"not that of certificate No. {row.number} as issued"
    yield Finding("content", words, same)


def _plain(root: Any) -> bytes:
    """Return a document's canonical form without what signing adds to it."""
    copy = etree.fromstring(etree.tostring(root))
    copy.attrib.pop(SCHEMA_LOCATION, None)
    comment = copy.find(dcc("comment"))
    if comment is not None and not len(comment):
        comment.getprevious().tail = comment.tail
        copy.remove(comment)
    plain: bytes = etree.tostring(copy, method="c14n", exclusive=True, with_comments=False)
    return plain


def _records(session: Session, row: IssuedCertificateRow) -> list[Finding]:
    """Say whether the chain to the calibration holds, and whether its raw data are what was recorded."""
    try:
        certified = calibration(session, row.calibration_sha256)
    except NotInDatabase:
        return [Finding("chain", "the calibration is not in the database", False)]
    names = {f"issued certificate {row.id}", f"calibration {certified.id}"}
    faults = [one for one in (*verify_issued(session), *verify_chain(session)) if one.row in names]
    head = f"certificate {row.sha256[:12]}... to calibration {certified.sha256[:12]}..."
    chain = Finding("chain", str(faults[0]) if faults else f"whole, from {head}", not faults)
    return [chain, _raw_data(certified)]


def _raw_data(row: CalibrationRow) -> Finding:
    """Hash the recorded files again where their folder is."""
    folder = None if row.campaign is None else Path(row.campaign.folder)
    if folder is None or not folder.is_dir():
        words = f"hashes of {len(row.inputs)} files stored; their folder is missing, so no file was checked"
        return Finding("raw data", words, None)
    for name, expected in row.inputs.items():
        file = folder / name
        found = sha256_of(file) if file.is_file() else "none"
        if found != expected:
            return Finding("raw data", f"{name}: found sha256 {found}, expected {expected}", False)
    return Finding("raw data", f"{len(row.inputs)} files of {folder} as recorded", True)
