"""The XML and PDF of a certificate put in their places: signed before they are written, no signed one lost."""

import hashlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from station.results.certificate.signing.signing_key import SigningKey

SIGNATURE_MARKS = {".xml": b"SignatureValue", ".pdf": b"/ByteRange"}  # XMLDSig 1.1, 4.3; ISO 32000-2, 12.8.1
Copy = tuple[Path, Callable[[bool], bytes], str]  # a place, what comes there if signed or not, what is said of it
Sign = Callable[[Path, bytes], bytes]


def looks_signed(path: Path) -> bool:
    """Return whether a file has a signature in it, told by its marks alone."""
    mark = SIGNATURE_MARKS.get(path.suffix.lower())
    return mark is not None and path.is_file() and mark in path.read_bytes()


def refuse_signed(paths: Iterable[Path]) -> None:
    """Raise `CannotWrite` where an unsigned file would take the place of a signed one."""
    from station.errors import CannotWrite

    for path in paths:
        if looks_signed(path):
            raise CannotWrite(path, "a signed file exists, and this one would have no signature")


def signer(db: str | None, number: str, key: "SigningKey", time_service: str | None) -> Sign:
    """Return what signs and records a file of a certificate."""

    def sign(path: Path, content: bytes) -> bytes:
        from fixtures_db.database import open_db
        from station.results.certificate.signing.signed_copies import signed_copy

        with open_db(db) as database:
            return signed_copy(database, number, path, content, key, time_service)

    return sign


def write_copies(copies: Iterable[Copy], sign: Sign | None) -> None:
    """Write each file once, signed where there is a key; raise what signing raised, after all are written.

    Where it fails they are written as issued, without signature, but none over a signed one.
    """
    from station.errors import StationError
    from station.files.atomic_file import replace_file

    failed: StationError | None = None
    for path, make, said in copies:
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
        typer.echo(f"{path}: written{said}")
        if signed is not None:
            typer.echo(f"{path}: signed, sha256 {hashlib.sha256(signed).hexdigest()}")
    if failed is not None:
        raise failed
