"""Signed certificates and anchor files at the command line: options checked, files written, findings printed."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

import typer

from procedures.errors import ErrorCode
from station.commands._options import signing_libraries
from station.text import plural

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from fixtures_db.hash_chain import ChainFault
    from fixtures_db.verification import Anchor
    from station.results.certificate.signing.key_certificate import Trust
    from station.results.certificate.signing.signing_key import SigningKey
    from station.results.certificate.signing.verification import Finding, Verified


def verify_signed(
    file: Path, roots: Sequence[Path], lists: Sequence[Path], laboratory: Path | None, db: str | None
) -> None:
    """Say what holds of a certificate's XML or PDF; a ``laboratory``'s file names more roots and lists.

    Raise `NotVerified` if something does not, `DataRefused` if it is no certificate, `ExtraMissing` without the
    libraries for signatures.
    """
    signing_libraries()
    from station.errors import NotVerified
    from station.files.xml_document import read_document
    from station.results.certificate.signing.key_certificate import read_trust
    from station.results.certificate.signing.verification import UNSIGNED, verify_pdf, verify_xml

    if laboratory is not None:
        from station.results.certificate.laboratory import read_laboratory

        known = read_laboratory(laboratory).signature
        roots = [*roots, *(laboratory.parent / name for name in known.roots)]
        lists = [*lists, *(laboratory.parent / name for name in known.revocation_lists)]
    look = verify_pdf if file.suffix.lower() == ".pdf" else verify_xml
    content = read_document(file)
    found = look(content, file, read_trust(roots, lists))
    findings = [*found.findings, *_by_database(db, content, found)]
    if any(one.name == "database" and one.holds for one in findings):  # each byte is known, signed or not
        findings = [replace(one, holds=None) if one == UNSIGNED else one for one in findings]
    found = replace(found, findings=findings)
    width = max(len(one.name) for one in found.findings)
    for one in found.findings:
        typer.echo(f"{one.name:<{width}}  {one.words}")
    if found.faults:
        raise NotVerified(file, found.faults, **_remedy(found.faults, bool(roots)))


def _remedy(faults: "dict[str, str]", is_trusting: bool) -> dict[str, str]:
    """Return what to do where all that fails is that nobody stated whom to trust; else nothing of its own."""
    of_trust = all(name.rpartition(": ")[2] in {"key", "time stamp"} for name in faults)
    return {"remedy": "give --trust ROOT.pem, a root that you trust"} if of_trust and not is_trusting else {}


def existing(db: str | None) -> str | None:
    """Return which database is meant, None where its file is not there: a check makes none."""
    from fixtures_db.database import default_path

    where = str(default_path()) if db is None else db
    return where if "://" in where or Path(where).exists() else None


def refuse_missing(db: str | None) -> None:
    """Raise `DataRefused` if the database named is a file that is not there."""
    from station.errors import DataRefused

    if db is not None and existing(db) is None:
        raise DataRefused(
            db,
            None,
            "no such file",
            "a station's database",
            "name the one that is there by --db",
            code=ErrorCode.FILE_MISSING,
        )


def _by_database(db: str | None, content: bytes, found: "Verified") -> list["Finding"]:
    from fixtures_db.database import open_db
    from station.results.certificate.signing.verification import database_findings

    if (where := existing(db)) is None:
        return []
    with open_db(where) as database, database.read() as session:
        return database_findings(session, database.url, content, found)


def signing_key(
    key: Path | None, token: str | None, descriptor: int | None, variable: str | None
) -> "SigningKey | None":
    """Return the laboratory's key, its password or PIN asked for; None where none is named.

    Raise `DataRefused` if it cannot sign, `ExtraMissing` without the libraries for signatures or tokens.
    """
    if key is not None and token is not None:
        raise typer.BadParameter("--sign KEY.p12 and --token URI: found two keys, expected one")
    if key is None and token is None:
        if descriptor is not None or variable is not None:
            raise typer.BadParameter("--password-fd and --password-env are of a key; expected --sign or --token")
        return None
    signing_libraries(token=token is not None)
    from station.results.certificate.signing.signing_key import key_password, read_signing_key, refuse_no_key

    if key is not None:
        refuse_no_key(key)  # before its password is asked for
        return read_signing_key(key, key_password(key, descriptor, variable))
    from station.results.certificate.signing.token_key import open_token_key

    return open_token_key(str(token), key_password(str(token), descriptor, variable))


SIGNATURE_MARKS = {".xml": b"SignatureValue", ".pdf": b"/ByteRange"}  # XMLDSig 1.1, 4.3; ISO 32000-2, 12.8.1
Copy = tuple[Path, Callable[[bool], bytes], str]  # a place, what comes there if signed or not, its text
Sign = Callable[[Path, bytes], bytes]


def looks_signed(path: Path) -> bool:
    """Return whether a file contains a signature, judged by its marks alone."""
    mark = SIGNATURE_MARKS.get(path.suffix.lower())
    return mark is not None and path.is_file() and mark in path.read_bytes()


def refuse_signed(paths: Iterable[Path]) -> None:
    """Raise `CannotWrite` where an unsigned file would take the place of a signed one."""
    from station.errors import CannotWrite

    for path in paths:
        if looks_signed(path):
            raise CannotWrite(path, "a signed file exists, and this one would have no signature")


def signer(db: str | None, number: str, key: "SigningKey", time_service: str | None) -> Sign:
    """Return what signs the XML or PDF of a certificate for a path, whose ending says which it is, and records it.

    It raises `DataRefused` for what cannot be signed, or is signed, and `NoTimeStamp` if the service gives none.
    """
    from cryptography.hazmat.primitives import hashes

    from fixtures_db.database import open_db
    from fixtures_db.issued_certificates import record_signed
    from station.files.xml_document import parse_xml
    from station.results.certificate.signing.pdf_signature import open_pdf, sign_pdf, verified_pdf
    from station.results.certificate.signing.xml_signature import sign_xml, verified_xml

    def sign(path: Path, content: bytes) -> bytes:
        with open_db(db) as database:
            if path.suffix == ".pdf":
                signed = sign_pdf(content, key, time_service)
                verified_pdf(signed, open_pdf(signed))
            else:
                signed = sign_xml(content, key, time_service)
                verified_xml(parse_xml(signed, path))
            sha256, fingerprint = hashlib.sha256(signed), key.certificate.fingerprint(hashes.SHA256())
            with database.write() as session:
                record_signed(session, number, path.suffix[1:], sha256.hexdigest(), fingerprint.hex())
        return signed

    return sign


def write_copies(copies: Iterable[Copy], sign: Sign | None) -> None:
    """Write each file once, signed where there is a key; raise what signing raised, after all are written.

    Where it fails they are written as issued, without signature, but none over a signed one.
    """
    from station.errors import StationError
    from station.files.atomic_file import replace_file

    failed: StationError | None = None
    for path, make, text in copies:
        signed = None
        if sign is not None and failed is None:
            try:
                signed = sign(path, make(True))
            except StationError as error:
                failed = error
        if signed is None and looks_signed(path):
            typer.echo(f"{path}: not changed, it was signed before")
            continue
        replace_file(path, make(False) if signed is None else signed)
        typer.echo(f"{path}: written{text}")
        if signed is not None:
            typer.echo(f"{path}: signed, sha256 {hashlib.sha256(signed).hexdigest()}")
    if failed is not None:
        raise failed


COPY_SUFFIXES = (".xml", ".pdf")  # what is written next to the HTML, under its name


def check_copy(order: Mapping[str, object]) -> None:
    """Raise if anything of an order, by option, is given with --copy: a copy says what was issued."""
    if given := [option for option, value in order.items() if value is not None]:
        text = ", ".join(given)
        raise typer.BadParameter(f"--copy writes the issued certificate unchanged: found {text}; omit one")


def check_out(out: Path | None) -> None:
    """Raise if the HTML would be written where the XML or the PDF belongs."""
    if out is not None and out.suffix.lower() in COPY_SUFFIXES:
        expected = out.with_suffix(".html").name
        raise typer.BadParameter(f"--out names the HTML: found {out.name!a}, expected such as {expected!a}")


def check_time_service(url: str | None, option: str = "--timestamp") -> None:
    """Raise if it is no address of a service: http or https, with a host."""
    try:
        parts = None if url is None else urlsplit(url)
        if parts is None or (parts.scheme in ("http", "https") and parts.hostname):
            return
    except ValueError:  # half an IPv6 address
        pass
    raise typer.BadParameter(f"{option}: found {url!a}, expected a URL such as https://time.example/tsr")


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
        As `station.files.database_files.read_anchor`, and of a certificate that witnesses nothing.
    NotVerified
        If the time stamp next to one is of something else, or of a service that the roots given do not lead to.
    """
    from station.files.database_files import read_anchor

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
    """Write an anchor and, of a ``service`` by URL, a time stamp over its bytes next to it.

    Raise `CannotWrite` if the place cannot be written, `NoTimeStamp` if the service gives none.
    """
    from station.files.atomic_file import replace_file
    from station.files.database_files import write_anchor

    stamp = to.with_name(to.name + STAMP_SUFFIX)
    stamp.unlink(missing_ok=True)  # one of the anchor before is of other bytes
    write_anchor(to, anchor)
    if service is not None:
        from station.results.certificate.signing.time_stamp import request_time_stamp

        replace_file(stamp, request_time_stamp(service, to.read_bytes()))


def _stamp_text(file: Path, trust: "Trust | None") -> str:
    """Return what the time stamp next to an anchor says; "" where there is none."""
    stamp = file.with_name(file.name + STAMP_SUFFIX)
    if not stamp.exists():
        return ""
    signing_libraries()
    from station.errors import NotVerified, SignatureBroken
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
    text = "; ".join(one.words for one in found.findings if one.name.endswith("time stamp"))
    return Kept(file, Anchor(journal=head.sha256, entries=head.entries), found.stamped, f", stamped {text}")


def witness_text(kept: Sequence[Kept], entries: int) -> str:
    """Return since when a database of ``entries`` is witnessed, in words."""
    if not kept:
        return "not witnessed: no --anchor was given, so a restored older copy would not be detected"
    since = entries - kept[0].anchor.entries
    return f"{kept[0].witness}; {plural(since, 'change')} since"
