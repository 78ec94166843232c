"""XAdES of a DCC: an enveloped signature over all of the document but itself, B-B or, with a time stamp, B-T.

The schema of 3.1.2 has no place for a signature next to ``dcc:comment``, which takes any element that a schema
declares: there it stands. It is put in before the document is signed, so that an empty one is signed, too.

Verification returns the bytes that were signed: what is verified is what is read. Refused before any mathematics:
more than one signature, a signature in another place, references or transforms not on the list, two elements of
one id. Each of these can give a valid signature over something else.
"""

import binascii
from base64 import b64decode, b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cryptography import x509
from lxml import etree
from signxml import CanonicalizationMethod, DigestAlgorithm, SignatureMethod
from signxml.exceptions import InvalidDigest, InvalidSignature
from signxml.xades import XAdESDataObjectFormat, XAdESSignatureConfiguration, XAdESSigner, XAdESVerifier

from procedures.errors import ErrorCode
from station.errors import DataRefused, SignatureBroken, refused_as
from station.files.xml_document import parse_xml
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.time_stamp import request_time_stamp
from station.results.certificate.signing.xml_schema import (
    CANONICAL,
    DS,
    DS_SCHEMA,
    ENVELOPED,
    EXCLUSIVE,
    ID_NAMES,
    NAMESPACES,
    SCHEMA_LOCATION,
    SIGNED_PROPERTIES,
    dcc,
    ds,
    xades,
)

FORMAT = XAdESDataObjectFormat("Digital calibration certificate", "text/xml")


def sign_xml(document: bytes, key: SigningKey, time_service: str | None = None) -> bytes:
    """Return a certificate with its signature, with a time stamp where a service's address is given.

    Raise `DataRefused` if the document is no DCC, or is signed already; `NoTimeStamp` if the service gives none.
    """
    root = parse_xml(document, "certificate")
    if root.tag != dcc("digitalCalibrationCertificate"):
        raise DataRefused("certificate", None, str(root.tag), "a DCC to sign")
    if next(root.iter(ds("Signature")), None) is not None:
        raise DataRefused(
            "certificate", None, "a signature in it", "none yet", "sign what was not", ErrorCode.SIGNATURE
        )
    _name_its_schema(root)
    etree.SubElement(_comment(root), ds("Signature"), {"Id": "placeholder"}, nsmap={"ds": DS})
    method = SignatureMethod.RSA_SHA256 if key.is_rsa else SignatureMethod.ECDSA_SHA256
    signer = XAdESSigner(
        data_object_format=FORMAT,
        signature_algorithm=method,
        digest_algorithm=DigestAlgorithm.SHA256,
        # what a reference without transforms means: signxml writes none for the properties' and the key's
        c14n_algorithm=CanonicalizationMethod.CANONICAL_XML_1_0,
    )
    certificates: list[x509.Certificate] = [key.certificate, *key.others]
    signed = signer.sign(root, key=key.private, cert=certificates, always_add_key_value=False)
    if time_service is not None:
        _add_time_stamp(signed, time_service)
    written: bytes = etree.tostring(signed, xml_declaration=True, encoding="UTF-8")
    return written + b"\n"


def _name_its_schema(root: Any) -> None:
    """Say where the signature's schema is: `dcc.xsd` asks that it be known, and does not name it itself."""
    where = root.get(SCHEMA_LOCATION, "").split()
    if DS not in where[::2]:
        root.set(SCHEMA_LOCATION, " ".join([*where, DS, DS_SCHEMA]))


def _comment(root: Any) -> Any:
    """Return the document's ``dcc:comment``, made where the schema has it if there is none."""
    if (found := root.find(dcc("comment"))) is not None:
        return found
    made = etree.Element(dcc("comment"))
    results = root.find(dcc("measurementResults"))
    if results is None:
        raise DataRefused("certificate", None, "no results", "a DCC to sign")
    results.addnext(made)  # takes what is behind the results with it: white space stays where it was
    made.tail, results.tail = results.tail, None
    return made


def _add_time_stamp(root: Any, service: str) -> None:
    """Add the token over the signature's value, an unsigned property of it: EN 319 132-1, 5.3."""
    signature = next(root.iter(ds("Signature")))
    token = request_time_stamp(service, signature_value(signature))
    (properties,) = signature.iterfind("ds:Object/xades:QualifyingProperties", NAMESPACES)
    unsigned = etree.SubElement(properties, xades("UnsignedProperties"))
    stamped = etree.SubElement(
        etree.SubElement(unsigned, xades("UnsignedSignatureProperties")), xades("SignatureTimeStamp")
    )
    etree.SubElement(stamped, ds("CanonicalizationMethod"), Algorithm=EXCLUSIVE)
    etree.SubElement(stamped, xades("EncapsulatedTimeStamp")).text = b64encode(token).decode()


def signature_value(signature: Any, method: str = EXCLUSIVE) -> bytes:
    """Return what a time stamp of a signature is over: its ``ds:SignatureValue`` in canonical form."""
    value = signature.find(ds("SignatureValue"))
    is_exclusive = method == EXCLUSIVE
    canonical: bytes = etree.tostring(value, method="c14n", exclusive=is_exclusive, with_comments=False)
    return canonical


METHODS = frozenset(
    getattr(SignatureMethod, f"{kind}_SHA{bits}") for kind in ("RSA", "ECDSA") for bits in (256, 384, 512)
)
DIGESTS = frozenset({DigestAlgorithm.SHA256, DigestAlgorithm.SHA384, DigestAlgorithm.SHA512})


@dataclass(frozen=True, slots=True)
class Signed:
    """What a signature covers and who made it.

    ``content`` are the bytes that were signed, of a PDF all of it, ``claimed`` the time that the signer states;
    ``token`` is the time stamp's, over ``stamped``, None where there is none.
    """

    content: bytes
    certificate: x509.Certificate
    others: tuple[x509.Certificate, ...]
    claimed: str
    token: bytes | None
    stamped: bytes


def is_signed(root: Any) -> bool:
    """Return whether there is any signature in a document."""
    return next(root.iter(ds("Signature")), None) is not None


def verified_xml(root: Any) -> Signed:
    """Return what the one signature of a document covers: all of it but the signature.

    Raise `SignatureBroken` if it does not hold, or is of another form than those on the list.
    """
    with refused_as("it does not hold"):
        return _verified(root)


def _verified(root: Any) -> Signed:
    signature = _the_signature(root)
    _refuse_twins(root)
    _refuse_broken_text(root)
    _check_references(signature)
    certificates = _certificates(signature)
    config = XAdESSignatureConfiguration(
        expect_references=True,  # counted above
        location=".//",  # there is one
        signature_methods=METHODS,
        digest_algorithms=DIGESTS,
        default_reference_c14n_method=CanonicalizationMethod.CANONICAL_XML_1_0,  # XMLDSig 1.1, 4.4.3.2
        verification_time=certificates[0].not_valid_before_utc,  # validity is judged apart
    )
    try:
        results = XAdESVerifier().verify(root, x509_cert=certificates[0], expect_config=config, id_attribute="Id")
    except InvalidDigest as error:
        raise SignatureBroken("it does not hold: what is signed was changed") from error
    except InvalidSignature as error:
        raise SignatureBroken("it does not hold: it was not made by the key it names, or was changed") from error
    (content,) = (one.signed_data for one in results if getattr(one.signed_xml, "tag", None) == root.tag)
    times = signature.iterfind(".//xades:SignedSignatureProperties/xades:SigningTime", NAMESPACES)
    token, stamped = _time_stamp(signature)
    claimed = next((str(one.text) for one in times), "")
    return Signed(content, certificates[0], tuple(certificates[1:]), claimed, token, stamped)


def _the_signature(root: Any) -> Any:
    found = list(root.iter(ds("Signature")))
    if len(found) != 1:
        raise SignatureBroken(f"found {len(found)} of them, expected one")
    parent = found[0].getparent()
    if parent is not root and not (parent.getparent() is root and parent.tag == dcc("comment")):
        raise SignatureBroken(f"found it in {parent.tag}, expected it in the document's dcc:comment or at its end")
    return found[0]


def _refuse_twins(root: Any) -> None:
    seen = set[str]()
    for element in root.iter(etree.Element):
        for name, value in element.attrib.items():
            if etree.QName(name).localname in ID_NAMES:
                if value in seen:
                    raise SignatureBroken(f"found two elements of id {value!r}, expected each once")
                seen.add(value)


def _refuse_broken_text(root: Any) -> None:
    """Refuse a comment within a value: it is not signed, and readers differ in what the value is then."""
    for comment in root.iter(etree.Comment):
        parent = comment.getparent()
        if parent is None:
            continue
        texts = [parent.text, *(one.tail for one in parent)]
        if any(text is not None and text.strip() for text in texts):
            raise SignatureBroken(f"found a comment within the text of {parent.tag}, expected none")


def _check_references(signature: Any) -> None:
    """Refuse references but to the document without its signature, to the signed properties and to the key."""
    allowed = {f"#{one.get('Id')}" for one in signature.findall(ds("KeyInfo")) if one.get("Id")}
    signed = signature.findall("ds:Object/xades:QualifyingProperties/xades:SignedProperties", NAMESPACES)
    if len(signed) != 1 or len(list(signature.iter(xades("SignedProperties")))) != 1 or not signed[0].get("Id"):
        raise SignatureBroken("found no signed properties, expected those of XAdES")
    of_properties = f"#{signed[0].get('Id')}"
    found = list[str]()
    for reference in signature.iterfind("ds:SignedInfo/ds:Reference", NAMESPACES):
        uri, transforms = reference.get("URI"), reference.findall("ds:Transforms/ds:Transform", NAMESPACES)
        names = [one.get("Algorithm") for one in transforms]
        if uri == "" and names[:1] == [ENVELOPED] and len(names) <= 2 and set(names[1:]) <= CANONICAL:
            found.append("document")
        elif uri == of_properties and reference.get("Type") == SIGNED_PROPERTIES and set(names) <= CANONICAL:
            found.append("properties")
        elif uri in allowed and set(names) <= CANONICAL:
            found.append("key")
        else:
            raise SignatureBroken(f"found it over {uri!r} by {' '.join(map(str, names)) or 'no transform'}, "
                                  "expected the whole document but itself")  # fmt: skip
    if sorted(found) not in (["document", "properties"], ["document", "key", "properties"]):
        raise SignatureBroken(f"found it over {', '.join(found) or 'nothing'}, expected the whole document, once")
    method = signature.find("ds:SignedInfo/ds:CanonicalizationMethod", NAMESPACES)
    if method is None or method.get("Algorithm") not in CANONICAL:
        raise SignatureBroken("found another canonical form, expected one without comments")


def _certificates(signature: Any) -> Sequence[x509.Certificate]:
    """Return the certificates in a signature, the key's own first."""
    texts = [one.text or "" for one in signature.iterfind("ds:KeyInfo/ds:X509Data/ds:X509Certificate", NAMESPACES)]
    with refused_as("found bytes that are no certificate, expected the key's"):
        found = [x509.load_der_x509_certificate(b64decode("".join(text.split()), validate=True)) for text in texts]
    if not found:
        raise SignatureBroken("found no certificate in it, expected the key's")
    return found


def _time_stamp(signature: Any) -> tuple[bytes | None, bytes]:
    """Return the token of a signature's time stamp, None where it has none, and what it is over."""
    below = "ds:Object/xades:QualifyingProperties/xades:UnsignedProperties/xades:UnsignedSignatureProperties"
    found = signature.findall(f"{below}/xades:SignatureTimeStamp", NAMESPACES)
    if not found:
        return None, b""
    method = found[0].find(ds("CanonicalizationMethod"))
    tokens = found[0].findall(xades("EncapsulatedTimeStamp"))
    name = "" if method is None else method.get("Algorithm")
    if len(found) != 1 or len(tokens) != 1 or (method is not None and name not in CANONICAL):
        raise SignatureBroken("found time stamps of another form, expected one with one token")
    try:
        token = b64decode("".join((tokens[0].text or "").split()), validate=True)
    except (ValueError, binascii.Error) as error:
        raise SignatureBroken("found a time stamp that is no base64, expected a token") from error
    return token, signature_value(signature, name)
