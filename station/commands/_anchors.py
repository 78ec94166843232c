"""Anchor files at the command line: compared with the database, written, stamped; since when they witness it."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from station.commands._options import signing_libraries
from station.text import plural

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from fixtures_db.hash_chain import ChainFault
    from fixtures_db.verification import Anchor
    from station.results.certificate.signing.key_certificate import Trust

STAMP_SUFFIX = ".tsr"


class Kept(NamedTuple):
    """An anchor that was kept, when it was written, and what its time stamp says; "" without one."""

    file: Path
    anchor: "Anchor"
    written: datetime
    stamp: str

    @property
    def witness(self) -> str:
        """Say until when the database is witnessed."""
        by = f"by {self.file}, written {self.written:%Y-%m-%d %H:%M} UTC{self.stamp}"
        if not self.anchor.entries:
            return f"witnessed {by}, before the journal existed: only the newest hash of each chain"
        return f"witnessed until entry {self.anchor.entries} {by}"


def read_kept(files: Sequence[Path], trust: "Trust | None") -> list[Kept]:
    """Return the anchors of files, certificates among them, the one of the longest journal first.

    Raises
    ------
    Altered, DataRefused
        As `station.files.anchor_file.read_anchor`, and of a certificate that witnesses nothing.
    NotVerified
        If the time stamp beside one is of something else, or of a service that the roots given do not lead to.
    """
    from station.files.anchor_file import read_anchor

    kept = [
        _certificate(file, trust)
        if file.suffix.lower() in {".xml", ".pdf"}
        else Kept(file, *read_anchor(file), _stamp_text(file, trust))
        for file in files
    ]
    return sorted(kept, key=lambda one: (one.anchor.entries, one.written), reverse=True)


def anchor_faults(session: "Session", kept: Sequence[Kept]) -> "list[ChainFault]":
    """Return all that is wrong with a database, and what of it is not as in the anchors."""
    from fixtures_db.journal import Head
    from fixtures_db.journal_verification import missing_entry
    from fixtures_db.verification import alterations, missing_manifests

    faults = alterations(session, kept[0].anchor if kept else None)
    for one in kept[1:]:
        if not one.anchor.entries:  # of a station that had no journal: each chain's head
            faults += alterations(session, one.anchor)
            continue
        faults += missing_entry(session.connection(), Head(one.anchor.entries, one.anchor.journal))
        faults += missing_manifests(session, one.anchor.manifests)
    return faults


def keep(to: Path, anchor: "Anchor", service: str | None) -> None:
    """Write an anchor and, of a ``service`` by URL, a time stamp over its bytes beside it.

    Raises
    ------
    CannotWrite
        If the place cannot be written.
    NoTimeStamp
        If the service gives none; the anchor is written.
    """
    from station.files.anchor_file import write_anchor
    from station.files.atomic_file import replace_file

    stamp = to.with_name(to.name + STAMP_SUFFIX)
    stamp.unlink(missing_ok=True)  # one of the anchor before is of other bytes
    write_anchor(to, anchor)
    if service is not None:
        from station.results.certificate.signing.time_stamp import request_time_stamp

        replace_file(stamp, request_time_stamp(service, to.read_bytes()))


def _stamp_text(file: Path, trust: "Trust | None") -> str:
    """Return what the time stamp beside an anchor says; "" where there is none."""
    stamp = file.with_name(file.name + STAMP_SUFFIX)
    if not stamp.exists():
        return ""
    signing_libraries()
    from station.results.certificate.signing.errors import NotVerified, SignatureBroken
    from station.results.certificate.signing.key_certificate import standing
    from station.results.certificate.signing.time_stamp import read_time_stamp

    try:
        found = read_time_stamp(stamp.read_bytes(), file.read_bytes())
    except SignatureBroken as error:
        raise NotVerified(stamp, {"time stamp": error.reason}, "use the anchor without it, or another") from error
    by = f", stamped {found.moment:%Y-%m-%d %H:%M} UTC by {found.certificate.subject.rfc4514_string()}"
    if trust is None:
        return f"{by}, not trusted by any root: give --trust ROOT.pem"
    service = standing(found.certificate, found.others, trust, found.moment, is_service=True)
    if not service.is_trusted:
        raise NotVerified(stamp, {"time stamp": f"{by[2:]}: {service.words}"}, "give the root of its service")
    return f"{by}: {service.words}"


def _certificate(file: Path, trust: "Trust | None") -> Kept:
    """Return the journal's head in a certificate as an anchor of the moment of its time stamp."""
    signing_libraries()
    from fixtures_db.verification import Anchor
    from station.files.xml_document import read_document
    from station.results.certificate.signing.key_certificate import Trust
    from station.results.certificate.signing.verification import stamped_head

    head, found = stamped_head(file, read_document(file), trust or Trust())
    assert found.stamped is not None
    said = "; ".join(one.words for one in found.findings if one.name.endswith("time stamp"))
    return Kept(file, Anchor(journal=head.sha256, entries=head.entries), found.stamped, f", stamped {said}")


def witness_text(kept: Sequence[Kept], entries: int) -> str:
    """Return since when a database of ``entries`` is witnessed, in words."""
    if not kept:
        return "not witnessed: no --anchor was given, so a restored older copy would not be detected"
    since = entries - kept[0].anchor.entries
    return f"{kept[0].witness}; {plural(since, 'change')} since"
