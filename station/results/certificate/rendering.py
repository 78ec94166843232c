"""A certificate as HTML that needs no other file and prints on numbered A4 pages, and as PDF.

Equal certificates give equal HTML. The last line of the PDF, a copy, names the hash of the HTML that was issued.
"""

from pathlib import Path

from fixtures_db.schema import IssuedCertificateRow
from station.errors import NoPdf
from station.files.atomic_file import replace_file
from station.results.certificate import certificate_wording, model_statement
from station.results.certificate.as_found import as_found
from station.results.certificate.certificate_inputs import Certificate
from station.results.certificate.conformity import conformity, printed
from station.results.certificate.printed_results import measured, result_groups
from station.results.html_templates import html_template


def render(certificate: Certificate) -> str:
    """Return the certificate's HTML; nothing is `missing` of its document."""
    document, results = certificate.document, measured(certificate.document)
    found = conformity(document, results)
    before = None
    if certificate.previous is not None:
        before = as_found(document, certificate.previous, certificate.previous_sha256)
    return html_template("certificate.html").render(
        certificate=certificate,
        document=document,
        lab=certificate.laboratory,
        procedure=document["procedure"],
        residual=document.get("residual", {}),
        groups=result_groups(results),
        found=found,
        conformity_rows=[] if found is None else printed(found.against),
        risks="" if found is None else certificate_wording.greatest_risks(found),
        before=before,
        conditions=certificate_wording.conditions(certificate),
        references=certificate_wording.references(certificate),
        deviations=certificate_wording.deviations(document),
        diagnosis=model_statement.diagnosis_said(document),
        taken_as_zero=model_statement.taken_as_zero(document),
        stated=[*model_statement.stated(document), certificate_wording.clock_of_the_laboratory(certificate)],
        is_timed=model_statement.is_timed(document),
        simulated=model_statement.is_simulated(document),
        minute=certificate_wording.minute,
        files=sorted(document["inputs"].items()),
    )


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
