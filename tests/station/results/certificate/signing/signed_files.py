"""A certificate signed by the laboratory of tests, as XML and as PDF with that XML attached."""

from pathlib import Path

from station.results.certificate.signing.key_certificate import Trust
from station.results.certificate.signing.pdf_signature import sign_pdf
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.xml_signature import sign_xml
from tests.station.results.certificate.signing.authorities import Owner, laboratory, root
from tests.station.results.certificate.signing.small_dcc import small_dcc
from tests.station.results.certificate.signing.time_service import time_service


def key_of(owner: Owner) -> SigningKey:
    return SigningKey(owner.private, owner.certificate, (root().certificate,))


def trusted() -> Trust:
    return Trust((root().certificate,))


def pdf_with(document: bytes) -> bytes:
    from weasyprint import HTML, Attachment

    attached = [Attachment(string=document, name="certificate.xml", relationship="Source")]
    return HTML(string="<h1>Certificate</h1>").write_pdf(attachments=attached)


def signed_files(folder: Path, document: bytes | None = None) -> tuple[bytes, bytes]:
    """XML and PDF, each with a time stamp."""
    key = key_of(laboratory())
    with time_service(folder) as url:
        document = sign_xml(document or small_dcc(), key, url)
        return document, sign_pdf(pdf_with(document), key, url)
