"""A certificate as the XML of a digital calibration certificate, validated by schemas and the rules of `dcclib`.

Equal certificates give equal bytes. `dcclib` is used where it is installed.
"""

from functools import cache
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from lxml import etree

from station.errors import BadXml
from station.results.certificate.content import CertificateContent
from station.results.certificate.dcc.administrative import administrative_data
from station.results.certificate.dcc.elements import dcc
from station.results.certificate.dcc.measurement import measurement_result
from station.results.certificate.signing.xml_schema import VERSION, read_schema


def certificate_xml(content: CertificateContent) -> bytes:
    """Return the XML of what a certificate says, UTF-8; it is not checked (`checked_xml`)."""
    root = dcc(
        "digitalCalibrationCertificate",
        administrative_data(content),
        dcc("measurementResults", measurement_result(content)),
        schemaVersion=VERSION,
    )
    written: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return written


SCHEMA_FOLDER = Path(str(resources.files("station.results.certificate.dcc") / "schema"))


def schema_faults(content: bytes) -> list[str]:
    """Return how an XML breaks the schemas of certificate and D-SI, each with its line; empty if it does not."""
    schema = _schema()
    tree = etree.fromstring(content, hardened_parser())
    if schema.validate(tree):
        return []
    return [f"line {one.line}: {one.message}" for one in schema.error_log]


def rule_faults(content: bytes) -> list[str] | None:
    """Return which rules of the Schematron of `dcclib` an XML breaks; None where that is not installed.

    Its hint at a later version of the schema, and other warnings, are no faults.
    """
    try:
        rules = schematron()
    except ImportError:
        return None
    found = rules.validate_str(content.decode())
    text = [*found.failed_assertions, *found.successful_reports]
    return [f"{one.location}: {' '.join(one.text.split())}" for one in text if one.role == "error"]


def held_against() -> str:
    """Return in words what a certificate's XML was held against before it was issued."""
    if find_spec("dcclib") is None:
        return "valid by its schema; the rules of dcclib were not checked: `make extra-dcc` installs them"
    return "valid by its schema and the rules of dcclib"


def hardened_parser() -> etree.XMLParser:
    """Return a parser that resolves no entity, loads no DTD, reads no network and takes no endless tree."""
    return etree.XMLParser(resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False)


@cache
def _schema() -> etree.XMLSchema:
    return read_schema((SCHEMA_FOLDER / "dcc.xsd").read_bytes())


@cache
def schematron() -> Any:
    """Return the validator of `dcclib`, read once; raise `ImportError` where that is not installed."""
    from dcclib.validation import SchematronValidator

    return SchematronValidator.for_dcc()


def load_validators() -> None:
    """Read schema and rules, which takes a second: before a lock is held."""
    schema_faults(b"<none/>")
    rule_faults(b"<none/>")


def checked_xml(content: CertificateContent) -> bytes:
    """Return a certificate's XML; the rules of `dcclib` are asked only where it is installed.

    Raise `BadXml` if it breaks the schema or a rule; nothing is issued then.
    """
    written = certificate_xml(content)
    if faults := schema_faults(written) or rule_faults(written):
        raise BadXml(content.certificate.number, faults[0], len(faults))
    return written
