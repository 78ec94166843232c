"""A certificate as the XML of a digital calibration certificate; equal certificates give equal bytes."""

from lxml import etree

from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.administrative import administrative_data
from station.results.certificate.dcc.elements import SCHEMA_VERSION, dcc
from station.results.certificate.dcc.measurement import measurement_result


def certificate_xml(content: CertificateContent) -> bytes:
    """Return the XML of what a certificate says, UTF-8; it is not checked (`validation`)."""
    root = dcc(
        "digitalCalibrationCertificate",
        administrative_data(content),
        dcc("measurementResults", measurement_result(content)),
        schemaVersion=SCHEMA_VERSION,
    )
    written: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return written
