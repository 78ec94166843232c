"""A certificate's file looked at from every side, each said in a sentence: what holds, what not, what is open."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from station.errors import DataRefused
from station.files.xml_document import parse_xml
from station.results.certificate.signing.errors import SignatureBroken
from station.results.certificate.signing.key_certificate import Trust, standing, subject
from station.results.certificate.signing.pdf_verification import (
    attached_files,
    has_signature,
    open_pdf,
    verified_pdf,
)
from station.results.certificate.signing.time_stamp import read_time_stamp
from station.results.certificate.signing.xml_names import dcc
from station.results.certificate.signing.xml_schema import VERSION, schema_fault
from station.results.certificate.signing.xml_verification import Signed, is_signed, verified_xml


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at, in a sentence; ``holds`` is None where nothing can be said of it."""

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
    said, moment = _signature(signed, trust, "the document")
    return Verified([*said, schema], parse_xml(signed.content, where), True, moment)


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
    said, moment = _signature(signed, trust, "the file")
    return _with_attached(Verified(said, None, True, moment), reader, where, trust)


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
    said = [Finding(f"{name}: {one.name}", one.words, one.holds) for one in inner.findings]
    if not is_signed(parse_xml(content, name)):  # the file's signature covers it, or is said to be none
        said = [one for one in said if not one.name.endswith(": signature")]
        return replace(found, findings=[*found.findings, *said], document=inner.document)
    is_whole, stamped = found.is_whole and inner.is_whole, found.stamped or inner.stamped
    return Verified([*found.findings, *said], inner.document, is_whole, stamped)


def _broken(error: SignatureBroken) -> Finding:
    return Finding("signature", error.reason, False)


def _schema(root: Any) -> Finding:
    version = root.get("schemaVersion")
    if version != VERSION:
        return Finding("schema", f"DCC {version}, which the station does not have: not checked", None)
    fault = schema_fault(root)
    return Finding("schema", fault or f"valid by DCC {VERSION} and D-SI", not fault)


def _signature(signed: Signed, trust: Trust, what: str) -> tuple[list[Finding], datetime | None]:
    """Return what is said of a signature that holds, its key and stamp, and the moment that the stamp proves."""
    stamp, moment = _time_stamp(signed, trust)
    key = standing(signed.certificate, signed.others, trust, moment or datetime.now(UTC))
    when = "" if not signed.claimed else f", by its signer's clock at {signed.claimed}"
    said = [
        Finding("signature", f"holds: {what} is as it was signed{when}", True),
        Finding("key", f"{subject(signed.certificate)}: {key.words}", key.is_trusted),
        stamp,
    ]
    return said, moment


def _time_stamp(signed: Signed, trust: Trust) -> tuple[Finding, datetime | None]:
    """Return what is said of a time stamp, and the moment that it proves; None if it proves none."""
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
