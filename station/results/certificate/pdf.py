"""An issued certificate as PDF: a copy, whose last line names the hash of the HTML that was issued."""

from pathlib import Path

from fixtures_db.schema import IssuedCertificateRow
from station.errors import NoPdf
from station.files.atomic_file import replace_file


def write_pdf(path: Path, row: IssuedCertificateRow, html: Path) -> None:
    """Write an issued certificate, whose HTML stands in ``html``, as PDF.

    Raises
    ------
    NoPdf
        If weasyprint or the libraries that it needs are not there.
    CannotWrite
        If the place cannot be written.
    """
    try:
        from weasyprint import CSS, HTML
    except (ImportError, OSError) as error:  # OSError: pango is no Python package and may be missing
        raise NoPdf(html, str(error).splitlines()[0]) from error
    line = f"Copy of the certificate with SHA-256 {row.html_sha256}"
    seal = CSS(
        string=f'.end::after {{ display: block; content: "{line}"; font: 7pt "DejaVu Sans Mono", monospace }}'
    )
    replace_file(path, HTML(string=row.html).write_pdf(stylesheets=[seal]))
