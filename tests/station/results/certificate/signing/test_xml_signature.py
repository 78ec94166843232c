"""A DCC is signed, stays valid by its schema, and is verified here and by others' programs."""

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from lxml import etree

from station.errors import DataRefused
from station.files.xml_document import parse_xml
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.verification import verify_xml
from station.results.certificate.signing.xml_schema import schema_fault
from station.results.certificate.signing.xml_signature import sign_xml
from station.results.certificate.signing.xml_verification import verified_xml
from tests.station.results.certificate.signing.authorities import issue, laboratory, root
from tests.station.results.certificate.signing.signed_files import key_of, trusted
from tests.station.results.certificate.signing.small_dcc import small_dcc

KEYS = {
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


def test_what_is_read_is_what_was_signed(files: tuple[bytes, bytes]) -> None:
    root_of_it = parse_xml(files[0], "signed")
    found = verify_xml(files[0], "signed", trusted())
    assert not found.faults
    assert found.is_whole
    assert found.document is not root_of_it
    assert next(found.document.iter("{http://www.w3.org/2000/09/xmldsig#}Signature"), None) is None


@pytest.mark.parametrize(
    "document", [b"<a/>", b"<dcc:digitalCalibrationCertificate xmlns:dcc='https://ptb.de/dcc'/>"]
)
def test_what_is_no_certificate_is_not_signed(document: bytes) -> None:
    with pytest.raises(DataRefused, match="expected a DCC to sign"):
        sign_xml(document, key_of(laboratory()))


def test_nothing_is_signed_twice(files: tuple[bytes, bytes]) -> None:
    with pytest.raises(DataRefused, match="found a signature in it, expected none yet"):
        sign_xml(files[0], key_of(laboratory()))


def test_a_document_with_a_comment_of_its_own_keeps_it() -> None:
    inside = '<dcc:comment><dcc:name xmlns:dcc="https://ptb.de/dcc"/></dcc:comment>'
    text = small_dcc().decode().replace("</dcc:measurementResults>", f"</dcc:measurementResults>{inside}")
    signed = sign_xml(text.encode(), SigningKey(laboratory().private, laboratory().certificate, ()))
    assert signed.count(b"<dcc:comment") == 1
    assert verify_xml(signed, "signed", trusted()).is_whole
