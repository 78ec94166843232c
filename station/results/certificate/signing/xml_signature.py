"""XAdES of a DCC: an enveloped signature over all of the document but itself, B-B or, with a time stamp, B-T.

The schema of 3.1.2 has no place for a signature beside ``dcc:comment``, which takes any element that a schema
declares: there it stands. It is put in before the document is signed, so that an empty one is signed, too.
"""

from base64 import b64encode
from typing import Any

from cryptography import x509
from lxml import etree
from signxml import CanonicalizationMethod, DigestAlgorithm, SignatureMethod
from signxml.xades import XAdESDataObjectFormat, XAdESSigner

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.files.xml_document import parse_xml
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.time_stamp import request_time_stamp
from station.results.certificate.signing.xml_names import (
    DS,
    DS_SCHEMA,
    EXCLUSIVE,
    NAMESPACES,
    SCHEMA_LOCATION,
    dcc,
    ds,
    xades,
)

FORMAT = XAdESDataObjectFormat("Digital calibration certificate", "text/xml")


def sign_xml(document: bytes, key: SigningKey, time_service: str | None = None) -> bytes:
    """Return a certificate with its signature, with a time stamp where a service's address is given.

    Raises
    ------
    DataRefused
        If the document is no DCC, or is signed already.
    NoTimeStamp
        If the service gives none.
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
