"""A certificate's XML, held against schema and rules before anybody sees it."""

from station.errors import BadXml
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.validation import rule_faults, schema_faults
from station.results.certificate.dcc.xml_writing import certificate_xml


def load_validators() -> None:
    """Read schema and rules, which takes a second: before a lock is held."""
    schema_faults(b"<none/>")
    rule_faults(b"<none/>")


def checked_xml(content: CertificateContent) -> bytes:
    """Return a certificate's XML; the rules of `dcclib` are asked only where it is installed.

    Raises
    ------
    BadXml
        If it breaks the schema or a rule; nothing is issued then.
    """
    written = certificate_xml(content)
    if faults := schema_faults(written) or rule_faults(written):
        raise BadXml(content.certificate.number, faults[0], len(faults))
    return written
