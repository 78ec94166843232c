"""What a signature must be, part by part: each that is otherwise is refused, and said to be that."""

from collections.abc import Callable
from typing import Any

import pytest
from lxml import etree
from signxml import CanonicalizationMethod, DigestAlgorithm, SignatureMethod
from signxml.xades import XAdESSigner

from station.errors import SignatureBroken
from station.results.certificate.signing.xml_schema import EXCLUSIVE, NAMESPACES, dcc, ds
from station.results.certificate.signing.xml_signature import sign_xml, signature_value, verified_xml
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import laboratory, root
from tests.station.results.certificate.signing.signed_files import key_of
from tests.station.results.certificate.signing.small_dcc import small_dcc

Edit = Callable[[Any], object]
COMMENTED = EXCLUSIVE + "WithComments"
OTHER_FORM = "found time stamps of another form, expected one with one token"
NOT_WHOLE = "expected the whole document but itself"


@pytest.fixture(scope="module")
def plain() -> bytes:
    """A signed document without a time stamp, with two certificates."""
    return sign_xml(small_dcc(), key_of(laboratory()))


def first(document: Any, path: str) -> Any:
    found = document.find(f".//{path}", NAMESPACES)
    assert found is not None, path
    return found


def gone(document: Any, path: str) -> None:
    found = first(document, path)
    found.getparent().remove(found)


def twice(document: Any, path: str) -> None:
    """Put an element there again, without the ids in it."""
    found = first(document, path)
    copy = etree.fromstring(etree.tostring(found))
    for one in copy.iter():
        one.attrib.pop("Id", None)
    found.addnext(copy)


def references(document: Any) -> dict[str, Any]:
    """The references to the document, to the signed properties and to the key."""
    names = {"": "document"}
    found = {}
    for one in document.iterfind(".//ds:SignedInfo/ds:Reference", NAMESPACES):
        kind = "properties" if one.get("Type") else "key"
        found[names.get(one.get("URI"), kind)] = one
    return found


def with_transform(document: Any, kind: str, algorithm: str) -> None:
    reference = references(document)[kind]
    transforms = reference.find(ds("Transforms"))
    if transforms is None:
        reference.insert(0, transforms := etree.Element(ds("Transforms")))
    etree.SubElement(transforms, ds("Transform"), Algorithm=algorithm)


def into(document: Any, *names: str) -> None:
    """Move the signature into an element within elements of these names."""
    signature, parent = first(document, "ds:Signature"), document
    for name in names:
        parent = etree.SubElement(parent, dcc(name))
    parent.append(signature)


def comment_in(document: Any, path: str, before: str | None, after: str | None) -> None:
    element = first(document, path)
    element.insert(0, made := etree.Comment("x"))
    element.text, made.tail = before, after


COMMENT = "found a comment within the text of {https://ptb.de/dcc}performanceLocation"
REFUSED: dict[str, tuple[Edit, str]] = {
    "in another element": (lambda it: into(it, "document"), "found it in {https://ptb.de/dcc}document"),
    "in a comment within": (lambda it: into(it, "document", "comment"), "found it in {https://ptb.de/dcc}comment"),
    # the canonical form has no comments: the mathematics would hold, and a reader take half of the text
    "a comment before text": (
        lambda it: comment_in(it, "dcc:performanceLocation", None, "laboratory"), COMMENT),
    "a comment behind text": (
        lambda it: comment_in(it, "dcc:performanceLocation", "laboratory", None), COMMENT),
    "three transforms": (lambda it: with_transform(it, "document", EXCLUSIVE), NOT_WHOLE),
    "not the document": (lambda it: gone(it, "ds:Reference"), "expected the whole document, once"),
    "no certificate": (lambda it: gone(it, "ds:X509Data"), "found no certificate in it"),
    "another value": (
        lambda it: setattr(first(it, "dcc:performanceLocation"), "text", "elsewhere"), "it does not hold"),
    "another signature": (lambda it: setattr(first(it, "ds:SignatureValue"), "text", "AAAA"), "it does not hold"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_signature_of_another_form_is_refused_with_what_is_wrong(plain: bytes, name: str) -> None:
    edit, reported = REFUSED[name]
    document = etree.fromstring(plain)
    edit(document)
    with pytest.raises(SignatureBroken) as caught:
        verified_xml(document)
    assert reported in caught.value.reason


HOLDS: dict[str, Edit] = {
    "nothing": lambda it: None,
    "a comment among elements": lambda it: it.insert(1, etree.Comment("by hand")),
    "a comment in an empty element": lambda it: comment_in(it, "ds:Object", None, " "),
    "a comment outside": lambda it: it.addprevious(etree.Comment("by hand")),
    "lines in a certificate": lambda it: setattr(
        first(it, "ds:X509Certificate"), "text", first(it, "ds:X509Certificate").text
    ),
}


@pytest.mark.parametrize("name", HOLDS)
def test_what_says_the_same_holds(plain: bytes, name: str) -> None:
    document = etree.fromstring(plain)
    HOLDS[name](document)
    found = verified_xml(document)
    assert (found.certificate, found.others) == (laboratory().certificate, (root().certificate,))
    assert (found.token, found.stamped) == (None, b"")
    assert found.claimed == first(document, "xades:SigningTime").text
    assert etree.fromstring(found.content).tag == document.tag


@pytest.mark.parametrize(
    ("method", "digest", "is_accepted"),
    [
        (SignatureMethod.RSA_SHA256, DigestAlgorithm.SHA256, True),
        (SignatureMethod.RSA_SHA384, DigestAlgorithm.SHA384, True),
        (SignatureMethod.RSA_SHA512, DigestAlgorithm.SHA512, True),
        (SignatureMethod.RSA_SHA224, DigestAlgorithm.SHA256, False),
        (SignatureMethod.SHA256_RSA_MGF1, DigestAlgorithm.SHA256, False),
        (SignatureMethod.RSA_SHA256, DigestAlgorithm.SHA224, False),
        (SignatureMethod.RSA_SHA256, DigestAlgorithm.SHA3_256, False),
    ],
)
def test_only_the_methods_and_digests_on_the_list_are_accepted(
    method: SignatureMethod, digest: DigestAlgorithm, is_accepted: bool
) -> None:
    form = CanonicalizationMethod.CANONICAL_XML_1_0
    signer = XAdESSigner(signature_algorithm=method, digest_algorithm=digest, c14n_algorithm=form)
    signed = signer.sign(
        etree.fromstring(small_dcc()), key=laboratory().private, cert=[laboratory().certificate],
        always_add_key_value=False,
    )  # fmt: skip
    document = etree.fromstring(etree.tostring(signed))
    if is_accepted:
        assert verified_xml(document).others == ()
        return
    with refused(SignatureBroken):
        verified_xml(document)


def test_a_time_stamp_is_over_the_signatures_value_in_the_form_that_it_names(files: tuple[bytes, bytes]) -> None:
    document = etree.fromstring(files[0])
    signature, stamp = first(document, "ds:Signature"), first(document, "xades:SignatureTimeStamp")
    exclusive = verified_xml(document)
    assert exclusive.token is not None
    assert exclusive.stamped == signature_value(signature)
    stamp.remove(stamp.find(ds("CanonicalizationMethod")))
    inclusive = verified_xml(document)
    assert inclusive.token == exclusive.token
    assert inclusive.stamped == signature_value(signature, "")
    text = first(signature, "ds:SignatureValue").text
    own = f'<ds:SignatureValue xmlns:ds="{NAMESPACES["ds"]}"'
    assert exclusive.stamped.decode().startswith(own)
    assert exclusive.stamped.decode().endswith(f">{text}</ds:SignatureValue>")
    assert b"https://ptb.de/dcc" not in exclusive.stamped
    assert b"https://ptb.de/dcc" in inclusive.stamped


STAMPS: dict[str, tuple[Edit, str]] = {
    "two stamps": (lambda it: twice(it, "xades:SignatureTimeStamp"), OTHER_FORM),
    "two tokens": (lambda it: twice(it, "xades:EncapsulatedTimeStamp"), OTHER_FORM),
    "with comments": (
        lambda it: first(it, "xades:SignatureTimeStamp/ds:CanonicalizationMethod").set("Algorithm", COMMENTED),
        OTHER_FORM,
    ),
    "no base64": (
        lambda it: setattr(first(it, "xades:EncapsulatedTimeStamp"), "text", "*AAAA"),
        "found a time stamp that is no base64, expected a token",
    ),
}


@pytest.mark.parametrize("name", STAMPS)
def test_time_stamps_of_another_form_are_refused(files: tuple[bytes, bytes], name: str) -> None:
    edit, reported = STAMPS[name]
    document = etree.fromstring(files[0])
    edit(document)
    with pytest.raises(SignatureBroken) as caught:
        verified_xml(document)
    assert caught.value.reason == reported
