"""A certificate's file verified: by its own signature, by schema, and by the database that issued it.

Each finding is a sentence: what holds, what does not, what is open. The database gives the recorded bytes, the
chain and the raw data's hashes; the journal's code in a signed and stamped certificate shows what the database
held then.
"""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from lxml import etree
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import verify_rows
from fixtures_db.errors import NotInDatabase
from fixtures_db.issued_certificates import issued_numbered, issued_of, signed_as, verify_issued
from fixtures_db.journal import Head, read_code
from fixtures_db.journal_verification import missing_entry
from fixtures_db.schema import CalibrationRow, IssuedCertificateRow, SignedFileRow
from fixtures_db.stored_calibrations import calibration, verify_chain
from station.errors import DataRefused, NotVerified, SignatureBroken
from station.files.sha256sums import sha256_of
from station.files.xml_document import parse_xml
from station.results.certificate.signing.key_certificate import Trust, standing, subject
from station.results.certificate.signing.pdf_signature import (
    attached_files,
    has_signature,
    open_pdf,
    verified_pdf,
)
from station.results.certificate.signing.time_stamp import read_time_stamp
from station.results.certificate.signing.xml_schema import NAMESPACES, SCHEMA_LOCATION, VERSION, dcc, schema_fault
from station.results.certificate.signing.xml_signature import Signed, is_signed, verified_xml


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at, in a sentence; ``holds`` is None where nothing can be reported of it."""

    name: str
    words: str
    holds: bool | None


PDF_MARK = b"%PDF-"
UNSIGNED = Finding("signature", "none: author and integrity cannot be proved", False)


@dataclass(frozen=True, slots=True)
class Verified:
    """What was found of a file; ``document`` is the DCC's root as it was signed, None where there is none to read.

    ``is_whole`` says whether its signature holds, whosever that is; ``stamped`` is what its time stamp proves.
    """

    findings: Sequence[Finding]
    document: Any = field(default=None)
    is_whole: bool = False
    stamped: datetime | None = None

    @property
    def faults(self) -> dict[str, str]:
        """What does not hold, by name."""
        return {one.name: one.words for one in self.findings if one.holds is False}


def verify_xml(content: bytes, where: str | Path, trust: Trust) -> Verified:
    """Look at a DCC; raise `DataRefused` if it is no XML that is read, or no DCC."""
    root = parse_xml(content, where)
    if root.tag != dcc("digitalCalibrationCertificate"):
        raise DataRefused(where, None, f"an element {root.tag}", "a digital calibration certificate")
    schema = _schema(root)
    if not is_signed(root):
        return Verified([UNSIGNED, schema], root)
    try:
        signed = verified_xml(root)
    except SignatureBroken as error:
        return Verified([_broken(error), schema])
    # what is read from here on is what was signed, made again from those bytes
    stated, moment = _signature(signed, trust, "the document")
    return Verified([*stated, schema], parse_xml(signed.content, where), True, moment)


def verify_pdf(content: bytes, where: str | Path, trust: Trust) -> Verified:
    """Look at a PDF and at the DCC attached to it; raise `DataRefused` where either is none that is read."""
    if not content.startswith(PDF_MARK):
        raise DataRefused(where, None, "no PDF", "a certificate's PDF", "give the file as issued")
    try:
        reader = open_pdf(content)
        is_signed_pdf = has_signature(reader)
    except SignatureBroken as error:
        remedy = "get it again from whoever issued it"
        raise DataRefused(where, None, error.reason.removeprefix("found "), "a whole PDF", remedy) from error
    if not is_signed_pdf:
        return _with_attached(Verified([UNSIGNED]), reader, where, trust)
    try:
        signed = verified_pdf(content, reader)
    except SignatureBroken as error:
        return Verified([_broken(error)])
    stated, moment = _signature(signed, trust, "the file")
    return _with_attached(Verified(stated, None, True, moment), reader, where, trust)


def _with_attached(found: Verified, reader: Any, where: str | Path, trust: Trust) -> Verified:
    """Add what is found of the attached DCC, the one file of XML."""
    try:
        attached = {name: one for name, one in attached_files(reader).items() if name.lower().endswith(".xml")}
    except SignatureBroken as error:
        return Verified([*found.findings, Finding("attached XML", error.reason, False)])
    if len(attached) != 1:
        words = f"{len(attached) or 'none'} attached"
        return Verified([*found.findings, Finding("attached XML", words, False if attached else None)], None)
    ((name, content),) = attached.items()
    inner = verify_xml(content, f"{where}: {name}", trust)
    stated = [Finding(f"{name}: {one.name}", one.words, one.holds) for one in inner.findings]
    if not is_signed(parse_xml(content, name)):  # the file's signature covers it, or is reported to be none
        stated = [one for one in stated if not one.name.endswith(": signature")]
        return replace(found, findings=[*found.findings, *stated], document=inner.document)
    is_whole, stamped = found.is_whole and inner.is_whole, found.stamped or inner.stamped
    return Verified([*found.findings, *stated], inner.document, is_whole, stamped)


def _broken(error: SignatureBroken) -> Finding:
    return Finding("signature", error.reason, False)


def _schema(root: Any) -> Finding:
    version = root.get("schemaVersion")
    if version != VERSION:
        return Finding("schema", f"DCC {version}, which the station does not have: not checked", None)
    fault = schema_fault(root)
    return Finding("schema", fault or f"valid by DCC {VERSION} and D-SI", not fault)


def _signature(signed: Signed, trust: Trust, what: str) -> tuple[list[Finding], datetime | None]:
    """Return what is known of a signature that holds, its key and stamp, and the moment that the stamp proves."""
    stamp, moment = _time_stamp(signed, trust)
    key = standing(signed.certificate, signed.others, trust, moment or datetime.now(UTC))
    when = "" if not signed.claimed else f", by its signer's clock at {signed.claimed}"
    stated = [
        Finding("signature", f"holds: {what} is as it was signed{when}", True),
        Finding("key", f"{subject(signed.certificate)}: {key.words}", key.is_trusted),
        stamp,
    ]
    return stated, moment


def _time_stamp(signed: Signed, trust: Trust) -> tuple[Finding, datetime | None]:
    """Return what is reported of a time stamp, and the moment that it proves; None if it proves none."""
    if signed.token is None:
        return Finding("time stamp", "none: the time of signing cannot be proved", None), None
    try:
        stamp = read_time_stamp(signed.token, signed.stamped)
    except SignatureBroken as error:
        return Finding("time stamp", error.reason, False), None
    service = standing(stamp.certificate, stamp.others, trust, stamp.moment, is_service=True)
    words = (
        f"{stamp.moment:%Y-%m-%d %H:%M:%S} UTC by {stamp.certificate.subject.rfc4514_string()}: {service.words}"
    )
    return Finding("time stamp", words, service.is_trusted), stamp.moment if service.is_trusted else None


_HEADS = ".//dcc:quantity[@refType='fog_head']/dcc:noQuantity/dcc:content"


def stated_head(document: Any) -> Head | None:
    """Return the journal's head that a DCC states; None where there is none, as in those of older stations."""
    texts = [] if document is None else document.findall(_HEADS, NAMESPACES)
    return next((head for one in texts if (head := read_code(one.text or "")) is not None), None)


def journal_finding(session: Session, found: Verified) -> list[Finding]:
    """Say whether the journal still has the entry that a certificate states as its newest of then."""
    if (head := stated_head(found.document)) is None:
        return []
    if faults := missing_entry(session.connection(), head):
        words = f"{faults[0]}: an older copy was restored, or the journal was restarted"
        return [Finding("journal", words, False)]
    when = "" if found.stamped is None else f", stamped {found.stamped:%Y-%m-%d %H:%M} UTC"
    by = f"this confirms all entries before it{when}" if found.is_whole else "unsigned, this confirms nothing"
    return [Finding("journal", f"has entry {head.entries} as stated; {by}", True)]


def stamped_head(file: Path, content: bytes, trust: Trust) -> tuple[Head, Verified]:
    """Return the journal's head in a certificate's XML or PDF, whose signature and time stamp hold.

    Raise `NotVerified` if signature, key or stamp does not hold; `DataRefused` if it has no stamp, or states no
    head: it is then no witness.
    """
    found = (verify_pdf if file.suffix.lower() == ".pdf" else verify_xml)(content, file, trust)
    if found.faults:
        raise NotVerified(file, found.faults, "give --trust ROOT.pem, or an anchor file")
    head = stated_head(found.document)
    if head is None or found.stamped is None:
        lacks = "no code of the journal" if head is None else "no time stamp"
        expected = "a certificate whose time stamp covers the journal's code"
        raise DataRefused(file, None, lacks, expected, "give one, or an anchor file")
    return head, found


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
    stated = [_bytes(session, row, signed, sha256), *_content(row, found.document), *_records(session, row)]
    return [*stated, *journal_finding(session, found)]


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
