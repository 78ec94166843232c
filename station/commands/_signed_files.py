"""Signed certificates at the command line: what was found of one, a line each."""

from collections.abc import Sequence
from pathlib import Path

import typer

from station.commands._optional import signing_libraries


def verify_signed(file: Path, roots: Sequence[Path], lists: Sequence[Path], db: str | None) -> None:
    """Say what holds of a certificate's XML or PDF.

    Raises
    ------
    NotVerified
        If something does not.
    DataRefused
        If it is no certificate that is read.
    ExtraMissing
        If the libraries for signatures are not installed.
    """
    signing_libraries()
    from station.files.xml_document import read_document
    from station.results.certificate.signing.errors import NotVerified
    from station.results.certificate.signing.key_certificate import read_trust
    from station.results.certificate.signing.verification import verify_pdf, verify_xml

    look = verify_pdf if file.suffix.lower() == ".pdf" else verify_xml
    found = look(read_document(file), file, read_trust(roots, lists))
    width = max(len(one.name) for one in found.findings)
    for one in found.findings:
        typer.echo(f"{one.name:<{width}}  {one.words}")
    if found.faults:
        raise NotVerified(file, found.faults)
