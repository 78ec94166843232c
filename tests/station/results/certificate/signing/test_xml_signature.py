"""A DCC is signed, stays valid by its schema, and is verified here and by others' programs."""

from collections.abc import Callable

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from lxml import etree

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.xml_document import parse_xml
from station.results.certificate.signing.xml_schema import (
    DS,
    DS_SCHEMA,
    SCHEMA_LOCATION,
    dcc,
    ds,
    schema_fault,
    xades,
)
from station.results.certificate.signing.xml_signature import sign_xml, verified_xml
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import Owner, issue, laboratory, root
from tests.station.results.certificate.signing.signed_files import key_of
from tests.station.results.certificate.signing.small_dcc import small_dcc

KEYS: dict[str, Callable[[], Owner]] = {
    "RSA": laboratory,
    "P-256": lambda: issue("EC", ec.generate_private_key(ec.SECP256R1()), root()),
    "P-521": lambda: issue("EC", ec.generate_private_key(ec.SECP521R1()), root()),
}


@pytest.mark.parametrize("kind", KEYS)
def test_a_signed_document_is_valid_by_its_schema_and_holds(kind: str) -> None:
    signed = parse_xml(sign_xml(small_dcc(), key_of(KEYS[kind]())), "signed")
    assert schema_fault(signed) == ""
    assert verified_xml(signed).token is None


def test_another_program_verifies_it(files: tuple[bytes, bytes]) -> None:
    xmlsec = pytest.importorskip("xmlsec")
    document = etree.fromstring(files[0])
    xmlsec.tree.add_ids(document, ["Id"])
    manager = xmlsec.KeysManager()
    pem = root().certificate.public_bytes(xmlsec_pem())
    manager.add_key(xmlsec.Key.from_memory(pem, xmlsec.KeyFormat.CERT_PEM))
    manager.load_cert_from_memory(pem, xmlsec.KeyFormat.PEM, xmlsec.KeyDataType.TRUSTED)
    xmlsec.SignatureContext(manager).verify(xmlsec.tree.find_node(document, xmlsec.Node.SIGNATURE))


def xmlsec_pem() -> object:
    from cryptography.hazmat.primitives.serialization import Encoding

    return Encoding.PEM


def test_nothing_is_signed_twice(files: tuple[bytes, bytes]) -> None:
    with refused(DataRefused, ErrorCode.SIGNATURE):
        sign_xml(files[0], key_of(laboratory()))


def algorithms(signed: bytes, name: str) -> set[str]:
    return {one.get("Algorithm", "") for one in etree.fromstring(signed).iter(ds(name))}


@pytest.mark.parametrize(("kind", "method"), [("RSA", "rsa-sha256"), ("P-256", "ecdsa-sha256")])
def test_a_signature_names_its_methods_and_its_certificates_and_what_it_is_over(kind: str, method: str) -> None:
    owner = KEYS[kind]()
    signed = sign_xml(small_dcc(), key_of(owner))
    assert signed.startswith(b"<?xml version='1.0' encoding='UTF-8'?>\n<dcc:digitalCalibrationCertificate ")
    assert signed.endswith(b"</dcc:digitalCalibrationCertificate>\n")
    assert algorithms(signed, "SignatureMethod") == {f"http://www.w3.org/2001/04/xmldsig-more#{method}"}
    assert algorithms(signed, "DigestMethod") == {"http://www.w3.org/2001/04/xmlenc#sha256"}
    form = "http://www.w3.org/TR/2001/REC-xml-c14n-20010315"
    assert algorithms(signed, "CanonicalizationMethod") == {form}
    document = etree.fromstring(signed)
    assert len(list(document.iter(ds("X509Certificate")))) == 2
    assert document.find(f".//{ds('KeyValue')}") is None
    assert [one.text for one in document.iter(xades("Description"))] == ["Digital calibration certificate"]
    assert [one.text for one in document.iter(xades("MimeType"))] == ["text/xml"]
    found = verified_xml(document)
    assert (found.certificate, found.others) == (owner.certificate, (root().certificate,))


def canonical(document: bytes) -> bytes:
    """A document without the signature, its comment and where its schema is."""
    made = etree.fromstring(document)
    made.attrib.pop(SCHEMA_LOCATION, None)
    if (comment := made.find(dcc("comment"))) is not None:
        before = comment.getprevious()
        assert before is not None
        assert (before.tag, before.tail) == (dcc("measurementResults"), None)
        before.tail = comment.tail
        made.remove(comment)
    plain: bytes = etree.tostring(made, method="c14n", exclusive=True)
    return plain


@pytest.mark.parametrize("behind", ["", "  <dcc:document/>\n"])
def test_signing_adds_a_comment_behind_the_results_and_leaves_every_other_byte(behind: str) -> None:
    text = small_dcc().decode().replace("</dcc:measurementResults>\n", f"</dcc:measurementResults>\n{behind}")
    signed = sign_xml(text.encode(), key_of(laboratory()))
    (comment,) = etree.fromstring(signed).iter(dcc("comment"))
    assert [one.tag for one in comment] == [ds("Signature")]
    assert canonical(signed) == canonical(text.encode())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", f"{DS} {DS_SCHEMA}"),
        ("https://ptb.de/dcc dcc.xsd", f"https://ptb.de/dcc dcc.xsd {DS} {DS_SCHEMA}"),
        (f"https://ptb.de/dcc dcc.xsd {DS} mine.xsd", f"https://ptb.de/dcc dcc.xsd {DS} mine.xsd"),
        (f"https://ptb.de/dcc {DS}", f"https://ptb.de/dcc {DS} {DS} {DS_SCHEMA}"),
    ],
)
def test_the_signatures_schema_is_named_once_among_those_named(before: str, after: str) -> None:
    document = etree.fromstring(small_dcc())
    if before:
        document.set(SCHEMA_LOCATION, before)
    signed = sign_xml(etree.tostring(document), key_of(laboratory()))
    assert etree.fromstring(signed).get(SCHEMA_LOCATION) == after


def test_what_is_no_certificate_is_not_signed() -> None:
    bare = b"<dcc:digitalCalibrationCertificate xmlns:dcc='https://ptb.de/dcc'/>"
    for document in (b"<a/>", bare):
        with refused(DataRefused):
            sign_xml(document, key_of(laboratory()))
