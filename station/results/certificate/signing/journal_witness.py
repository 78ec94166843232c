"""The journal's code that a certificate states: signed and stamped, it says what the database held by then."""

from pathlib import Path
from typing import Any

from sqlalchemy.orm import Session

from fixtures_db.journal import Head, read_code
from fixtures_db.journal_verification import missing_entry
from station.errors import DataRefused
from station.results.certificate.signing.errors import NotVerified
from station.results.certificate.signing.key_certificate import Trust
from station.results.certificate.signing.verification import Finding, Verified, verify_pdf, verify_xml
from station.results.certificate.signing.xml_names import NAMESPACES

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

    Raises
    ------
    NotVerified
        If signature, key or stamp does not hold.
    DataRefused
        If it has no stamp, or states no head: it is then no witness.
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
