"""A certificate as HTML, by `templates/certificate.html`, and as PDF.

It needs no other file and prints on numbered A4 pages.

Equal certificates give equal HTML. The last line of the PDF, a copy, names the hash of the HTML that was issued.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

from fixtures_db.schema import IssuedCertificateRow
from station.errors import NoPdf
from station.results.certificate import model_statement, sentences
from station.results.certificate.conformity import AS_FOUND_K, printed
from station.results.certificate.content import CertificateContent, conditions, minute
from station.results.certificate.printed_results import result_groups, sources_in_words
from station.results.html_templates import html_template


def render(content: CertificateContent) -> str:
    """Return the HTML of what a certificate says."""
    document, found = content.document, content.found
    return html_template("certificate.html").render(
        {one.name: getattr(content, one.name) for one in fields(content)},
        document=document,
        groups=result_groups(content.results),
        sources=sources_in_words(content.results.values()),
        effects=model_statement.effect_rows(document),
        conformity_rows=[] if found is None else printed(found.against),
        as_found_k=f"{AS_FOUND_K:g}",
        conditions=conditions(content.certificate),
        content=content,
        say=sentences,
        minute=minute,
        files=sorted(document["inputs"].items()),
    )


SIGNED_LINE = """.signature td.line { border: 0 }
.signature td.line:first-child::before { content: "Signed electronically; the signature is in the file" }"""


def pdf_of(row: IssuedCertificateRow, html: Path, is_signed: bool = False) -> bytes:
    """Return an issued certificate, whose HTML stands in ``html``, as PDF: its XML attached, as PDF/A-3.

    One that will be signed says so where another has the line for a signature by hand.

    Raise `NoPdf` if weasyprint or the libraries that it needs are not there.
    """
    try:
        from weasyprint import CSS, HTML, Attachment
    except (ImportError, OSError) as error:  # OSError: pango is no Python package and may be missing
        raise NoPdf(html, str(error).splitlines()[0]) from error
    line = f"Copy of the certificate with SHA-256 {row.html_sha256}"
    seal = CSS(
        string=f'.end::after {{ display: block; content: "{line}"; font: 7pt "DejaVu Sans Mono", monospace }}'
    )
    sheets = [seal, CSS(string=SIGNED_LINE)] if is_signed else [seal]
    text = HTML(string=row.html)
    if row.dcc is None:
        with _dated(row):
            return bytes(text.write_pdf(stylesheets=sheets))
    attached = Attachment(
        string=row.dcc.encode(),
        name=f"{row.number}.xml",
        description="Digital Calibration Certificate: the same certificate as XML",
        created=row.issued_utc,
        modified=row.issued_utc,
        relationship="Alternative",
    )
    with _dated(row):
        return bytes(text.write_pdf(stylesheets=sheets, attachments=[attached], pdf_variant="pdf/a-3u"))


@contextmanager
def _dated(row: IssuedCertificateRow) -> Iterator[None]:
    """Give the embedded fonts the date of issue: with today's date a copy would differ from its original.

    Source: https://reproducible-builds.org/specs/source-date-epoch/
    """
    before = os.environ.get("SOURCE_DATE_EPOCH")
    os.environ["SOURCE_DATE_EPOCH"] = str(int(row.issued_utc.timestamp()))
    try:
        yield
    finally:
        del os.environ["SOURCE_DATE_EPOCH"]
        if before is not None:
            os.environ["SOURCE_DATE_EPOCH"] = before
