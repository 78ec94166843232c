"""Issue a certificate: numbered, recorded and handed out, in this order; list what a new issue changed.

The row, which holds all of it, is committed before the file is written. A kill before the commit leaves nothing, a
kill after it a certificate that was issued and can be handed out again (`copy_of`), byte by byte.
"""

import json
import re
from dataclasses import replace
from datetime import UTC, datetime
from html import unescape
from pathlib import Path

from sqlalchemy.orm import Session

from fixtures_db.database import Database
from fixtures_db.errors import NotInDatabase
from fixtures_db.hash_chain import GENESIS
from fixtures_db.issued_certificates import issued_of, next_number, record_issue
from fixtures_db.schema import CalibrationRow, IssuedCertificateRow
from fixtures_db.stored_calibrations import (
    calibrated_serials,
    calibration,
    calibration_before,
    calibrations_like,
    history,
)
from fixtures_db.verification import take_anchor
from station.errors import DataRefused, Incomplete
from station.files.sha256sums import sha256_of
from station.files.toml_file import checked_text
from station.results.certificate.content import Certificate, CertificateContent, ReplacedCertificate, content_of
from station.results.certificate.dcc.digital_certificate import checked_xml, load_validators
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import check_received, missing
from station.results.certificate.rendering import render

FIELDS_THAT_ALWAYS_CHANGE = {
    "Issued",
    "Newest calibration",
    "Newest face certificate",
    "Newest surface plate level",
    "Certificate before this",
    "Journal of the database",
}


TABLE = re.compile(r'<table(?: class="([^"]*)")?[^>]*>(.*?)</table>', re.DOTALL)
CELL = re.compile(r"<t[hd]\b[^>]*>(.*?)</t[hd]>", re.DOTALL)
TAG = re.compile(r"<[^>]*>")


def changed_fields(before: str, now: str) -> list[str]:
    """Return the labels of the fields that two certificates print otherwise, in the order of the newer."""
    old, new = _fields(before), _fields(now)
    names = [*new, *(name for name in old if name not in new)]
    return [name for name in names if old.get(name) != new.get(name) and name not in FIELDS_THAT_ALWAYS_CHANGE]


def _fields(html: str) -> dict[str, list[str]]:
    found = dict[str, list[str]]()
    for table, row in ((table, row) for table, rows in TABLE.findall(html) for row in rows.split("<tr>")[1:]):
        texts = [" ".join(unescape(TAG.sub("", cell)).split()) for cell in CELL.findall(row)]
        if table == "house":
            found["Laboratory"] = texts
        elif table.startswith("facts"):
            for label, text in zip(texts[::2], texts[1::2], strict=False):
                found.setdefault(label, []).append(text)
        elif table in {"references", "signature"} and texts[0]:
            found.setdefault(texts[0] if table == "references" else "Authorised by", []).append(" ".join(texts))
    return found


HASH_PREFIX = re.compile(r"[0-9a-f]{6,64}")


def find_calibration(session: Session, name: str) -> CalibrationRow:
    """Return a calibration by its file, the serial number of its unit (the newest), or the beginning of its hash.

    Raise `NotInDatabase` if there is none, or more than one begins so.
    """
    if (path := Path(name)).is_file():
        return calibration(session, sha256_of(path))
    if rows := history(session, name):
        return rows[-1]
    found = calibrations_like(session, name) if HASH_PREFIX.fullmatch(name) else []
    if len(found) == 1:
        return found[0]
    known = [row.sha256[:16] for row in found] or calibrated_serials(session)
    raise NotInDatabase("one calibration", name, known)


def issue(
    database: Database, name: str, laboratory: Laboratory, amend: str = "", *, digital: bool = False
) -> IssuedCertificateRow:
    """Make a certificate of a calibration and record it; the row's ``html`` is what is handed out.

    ``amend`` says why again where it was done before. ``digital``: the row's ``dcc`` is the same as the XML of a
    digital calibration certificate, held against its schema before it is recorded.

    Raise `DataRefused` if the unit was received after it was measured, or in the future; if ``amend`` cannot be
    printed; `Incomplete` naming all that is missing; a reason where a certificate of this calibration was issued
    before; `NotInDatabase` as `find_calibration`.
    """
    amend = _checked_reason(amend)
    import scipy.special  # noqa: F401  here, so that the lock is not held while it is imported

    if digital:
        load_validators()  # the same
    with database.write() as session:
        row = find_calibration(session, name)
        made = _certificate(session, row, laboratory, amend, digital)
        content = _content(session, made, row.sha256)
        issued = IssuedCertificateRow(
            number=made.number,
            replaces=None if made.replaced is None else made.replaced.number,
            calibration_sha256=row.sha256,
            issued_utc=made.issued_utc,
            laboratory=str(laboratory.laboratory.name),
            html=render(content),
            dcc=checked_xml(content).decode() if digital else None,
        )
        return record_issue(session, issued)


def _checked_reason(amend: str) -> str:
    """Return a reason without spaces around it; raise `DataRefused` if it is too long or not printable."""
    try:
        return checked_text(amend.strip())
    except ValueError as error:
        raise DataRefused("--amend", None, ascii(amend), str(error), "correct the option") from None


def _content(session: Session, made: Certificate, calibration_sha256: str) -> CertificateContent:
    """Return what a certificate says; one that replaces another names the fields that differ."""
    content = content_of(made)
    if made.replaced is None:
        return content
    changed = changed_fields(issued_of(session, calibration_sha256)[-1].html, render(content))
    return content_of(replace(made, replaced=replace(made.replaced, changed=tuple(changed))))


def copy_of(database: Database, name: str) -> IssuedCertificateRow:
    """Return the certificate in force of a calibration; raise `NotInDatabase` if none was issued."""
    with database.read() as session:
        row = find_calibration(session, name)
        if not (rows := issued_of(session, row.sha256)):
            raise NotInDatabase("certificate of calibration", row.sha256)
        return rows[-1]


def _certificate(session: Session, row: CalibrationRow, lab: Laboratory, amend: str, digital: bool) -> Certificate:
    document = json.loads(row.document)
    what = f"certificate of {document['model']} {document['serial']}"
    earlier = issued_of(session, row.sha256)
    lacking = missing(document, lab, digital=digital)
    if earlier and not amend:
        given = f"--amend TEXT: No. {earlier[-1].number} of this calibration was issued; --copy hands it out again"
        lacking.append(("reason for replacing it", given))
    if lacking:
        raise Incomplete(what, lacking)
    check_received(document, lab, datetime.now().astimezone())
    replaced = None
    if earlier:
        last = earlier[-1]
        replaced = ReplacedCertificate(last.number, last.issued_utc, last.dcc_sha256 or last.html_sha256, amend)
    now, before = datetime.now(UTC).replace(microsecond=0), calibration_before(session, row)
    return Certificate(
        next_number(session, lab.laboratory.number_prefix, now.year),
        now,
        document,
        row.sha256,
        lab,
        take_anchor(session),
        None if before is None else json.loads(before.document),
        GENESIS if before is None else before.sha256,
        replaced,
    )
