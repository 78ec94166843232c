"""A valid signature of something else: ways to have one are refused, also where mathematics would hold."""

from base64 import b64decode, b64encode
from collections.abc import Callable
from typing import Any

import pytest
from lxml import etree
from signxml import CanonicalizationMethod, SignatureReference
from signxml.xades import XAdESSigner

from station.errors import SignatureBroken
from station.results.certificate.signing.verification import verify_xml
from station.results.certificate.signing.xml_schema import ENVELOPED, NAMESPACES, dcc, ds
from station.results.certificate.signing.xml_signature import verified_xml
from tests.station.results.certificate.signing.authorities import laboratory
from tests.station.results.certificate.signing.signed_files import trusted
from tests.station.results.certificate.signing.small_dcc import small_dcc

INCLUSIVE = CanonicalizationMethod.CANONICAL_XML_1_0


def signed_over(references: list[SignatureReference], root: Any) -> Any:
    """A document with a genuine signature of the laboratory over parts of it."""
    signer = XAdESSigner(c14n_algorithm=INCLUSIVE)
    return signer.sign(
        root, key=laboratory().private, cert=[laboratory().certificate], reference_uri=references,
        always_add_key_value=False,
    )  # fmt: skip


def part(root: Any) -> Any:
    """Only the results signed."""
    root.find(f".//{dcc('measurementResult')}").set("id", "results")
    return signed_over([SignatureReference(URI="results", c14n_method=INCLUSIVE)], root)


def wrapped(root: Any) -> Any:
    """The signed original kept in the comment of a forged one."""
    whole = XAdESSigner(c14n_algorithm=INCLUSIVE).sign(
        root, key=laboratory().private, cert=[laboratory().certificate], always_add_key_value=False
    )
    forged = etree.fromstring(small_dcc(number="FORGED"))
    comment = etree.SubElement(forged, dcc("comment"))
    comment.append(whole)
    return forged


def twins(root: Any) -> Any:
    """Two elements of one id, of which one was signed."""
    signed = part(root)
    other = etree.fromstring(etree.tostring(signed.find(f".//{dcc('measurementResult')}")))
    signed.find(dcc("measurementResults")).insert(0, other)
    return signed


def another_transform(root: Any) -> Any:
    """The whole document, by a transform that leaves out what an expression says."""
    signed = whole(root)
    transforms = signed.find(".//ds:Transforms", NAMESPACES)
    made = etree.SubElement(transforms, ds("Transform"), Algorithm="http://www.w3.org/TR/1999/REC-xpath-19991116")
    etree.SubElement(made, ds("XPath")).text = "not(ancestor-or-self::dcc:results)"
    return signed


def whole(root: Any) -> Any:
    return XAdESSigner(c14n_algorithm=INCLUSIVE).sign(
        root, key=laboratory().private, cert=[laboratory().certificate], always_add_key_value=False
    )


def no_signature_left_out(root: Any) -> Any:
    """A reference without the enveloped transform."""
    signed = whole(root)
    for transform in signed.iter(ds("Transform")):
        if transform.get("Algorithm") == ENVELOPED:
            transform.getparent().remove(transform)
    return signed


def with_comments(root: Any) -> Any:
    signer = XAdESSigner(c14n_algorithm=CanonicalizationMethod.CANONICAL_XML_1_0_WITH_COMMENTS)
    return signer.sign(
        root, key=laboratory().private, cert=[laboratory().certificate], always_add_key_value=False
    )  # fmt: skip


def elsewhere(root: Any) -> Any:
    signed = whole(root)
    signed.find(f".//{dcc('coreData')}").append(signed.find(ds("Signature")))
    return signed


def two(root: Any) -> Any:
    signed = whole(root)
    return whole(signed)


def outside_address(root: Any) -> Any:
    signed = whole(root)
    signed.find(".//ds:Reference", NAMESPACES).set("URI", "file:///etc/passwd")
    return signed


def no_properties(root: Any) -> Any:
    signed = whole(root)
    found = signed.find(".//ds:Object", NAMESPACES)
    found.getparent().remove(found)
    return signed


def another_version(root: Any) -> Any:
    """A certificate of no version of X.509: its library raises what is no `ValueError`."""
    signed = whole(root)
    held = signed.find(".//ds:X509Certificate", NAMESPACES)
    der = b64decode(held.text)
    at = der.index(b"\xa0\x03\x02\x01\x02")  # [0] EXPLICIT version 2, RFC 5280, 4.1
    held.text = b64encode(der[: at + 4] + b"\x42" + der[at + 5 :]).decode()
    return signed


ATTACKS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "a part": (part, "found it over '#results'"),
    "wrapped": (wrapped, "expected it in the document's dcc:comment or at its end"),
    "twins": (twins, "found two elements of id 'results'"),
    "another transform": (another_transform, "REC-xpath-19991116"),
    "not enveloped": (no_signature_left_out, "expected the whole document but itself"),
    "with comments": (with_comments, "expected the whole document but itself"),
    "elsewhere": (elsewhere, "coreData, expected it in the document's dcc:comment"),
    "two": (two, "found 2 of them, expected one"),
    "outside": (outside_address, "found it over 'file:///etc/passwd'"),
    "another version": (another_version, "found bytes that are no certificate"),
    "no properties": (no_properties, "found no signed properties"),
}


def test_the_same_form_over_the_whole_document_holds() -> None:
    found = verify_xml(etree.tostring(whole(etree.fromstring(small_dcc()))), "signed", trusted())
    assert found.is_whole


@pytest.mark.parametrize("name", ATTACKS)
def test_a_signature_of_something_else_is_refused(name: str) -> None:
    attack, reported = ATTACKS[name]
    content = etree.tostring(attack(etree.fromstring(small_dcc())))
    with pytest.raises(SignatureBroken) as caught:
        verified_xml(etree.fromstring(content))
    assert reported in str(caught.value)
    found = verify_xml(content, "attacked", trusted())
    assert "signature" in found.faults
    assert found.document is None
    assert not found.is_whole
