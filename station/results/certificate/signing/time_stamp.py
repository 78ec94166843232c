"""Time stamps of RFC 3161: a service says when it saw a hash; asked for by URL, checked without a network."""

import hashlib
import urllib.error
import urllib.request
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from asn1crypto import cms, tsp
from asn1crypto import x509 as asn1_x509
from asn1crypto.core import VOID, Sequence
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509.oid import ExtendedKeyUsageOID
from pyhanko.sign.validation.generic_cms import validate_sig_integrity
from rfc3161_client import TimestampRequestBuilder
from rfc3161_client.base import HashAlgorithm

from station.errors import NoTimeStamp, SignatureBroken, first_line, refused_as

TIMEOUT_S = 30.0
MOST_BYTES = 1_000_000  # of an answer: tokens with their certificates have some 5 kB
GRANTED = frozenset({"granted", "granted_with_mods"})  # RFC 3161, 2.4.2
HASHES = frozenset({"sha256", "sha384", "sha512"})


class _Answer(Sequence):  # type: ignore[misc]
    """``TimeStampResp``; one that refuses has no token."""

    _fields = [("status", tsp.PKIStatusInfo), ("time_stamp_token", cms.ContentInfo, {"optional": True})]


@dataclass(frozen=True, slots=True)
class TimeStamp:
    """When a service saw what it stamped, and its own certificate; ``others`` came with the token."""

    moment: datetime
    certificate: x509.Certificate
    others: tuple[x509.Certificate, ...]


def request_time_stamp(url: str, data: bytes) -> bytes:
    """Return a service's token over the SHA-256 of ``data``, DER.

    Raise `NoTimeStamp` if the service does not answer, refuses, or its answer is of other data or another request.
    """
    asked = TimestampRequestBuilder(data, HashAlgorithm.SHA256).build()
    token = granted(url, ask_service(url, asked.as_bytes()))
    content: bytes = token.dump()
    try:
        read_time_stamp(content, data)
    except SignatureBroken as error:
        raise NoTimeStamp(url, error.reason) from error
    if token["content"]["encap_content_info"]["content"].parsed["nonce"].native != asked.nonce:
        raise NoTimeStamp(url, "the answer to another request")
    return content


def granted(url: str, answer: bytes) -> cms.ContentInfo:
    """Return the token in a service's answer; raise `NoTimeStamp` if it refused or the bytes are no answer."""
    try:
        # not by rfc3161_client, which refuses what common services send: certificates in another order than DER's
        response = _Answer.load(answer, strict=True)
        status, text = response["status"]["status"].native, response["status"]["status_string"].native
        token = response["time_stamp_token"]
    except (ValueError, TypeError) as error:
        raise NoTimeStamp(url, first_line(error)) from error
    if status not in GRANTED or token is VOID:
        raise NoTimeStamp(url, f"{status}: {' '.join(text or ['no reason given'])}")
    return token


def ask_service(url: str, request: bytes) -> bytes:
    """Return what a service answers to a request, DER; raise `NoTimeStamp` if it does not."""
    if not url.startswith(("http://", "https://")):
        raise NoTimeStamp(url, "no address that begins with http:// or https://")
    posted = urllib.request.Request(url, request, {"Content-Type": "application/timestamp-query"})
    try:
        with urllib.request.urlopen(posted, timeout=TIMEOUT_S) as answer:
            content: bytes = answer.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.reason if isinstance(error, urllib.error.URLError) else error
        raise NoTimeStamp(url, first_line(reason) if isinstance(reason, BaseException) else str(reason)) from error
    if len(content) > MOST_BYTES:
        raise NoTimeStamp(url, f"an answer of more than {MOST_BYTES} bytes")
    return content


def read_time_stamp(token: bytes, data: bytes) -> TimeStamp:
    """Return what a token says of ``data``; whom its certificate belongs to is judged elsewhere.

    Raise `SignatureBroken` if it is no token, is of other data, its certificate is for other purposes, or its
    signature does not hold.
    """
    with refused_as("its time stamp does not hold"):
        signed = cms.ContentInfo.load(token, strict=True)["content"]
        certificates = [x509.load_der_x509_certificate(one.chosen.dump()) for one in signed["certificates"]]
        (signer,) = signed["signer_infos"]
        content = signed["encap_content_info"]["content"]
        stamped = content.parsed
        certificate = _signer(certificates, signer["sid"].chosen)
        _check(signed, signer, certificate, bytes(content))
        imprint = stamped["message_imprint"]
        algorithm = imprint["hash_algorithm"]["algorithm"].native
        if algorithm not in HASHES or hashlib.new(algorithm, data).digest() != imprint["hashed_message"].native:
            raise SignatureBroken("its time stamp is of something else")
    return TimeStamp(stamped["gen_time"].native, certificate, tuple(c for c in certificates if c != certificate))


def _check(signed: Any, signer: Any, certificate: x509.Certificate, content: bytes) -> None:
    """Raise `ValueError` if a token's signature is not by its service, or the service's key is for another use."""
    if signed["encap_content_info"]["content_type"].native != "tst_info":
        raise ValueError("it is no token")
    purposes = certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage)
    if ExtendedKeyUsageOID.TIME_STAMPING not in purposes.value:
        raise ValueError("its service's certificate is not for time stamps")
    digest = hashlib.new(signer["digest_algorithm"]["algorithm"].native, content).digest()
    as_asn1 = asn1_x509.Certificate.load(certificate.public_bytes(Encoding.DER))
    if validate_sig_integrity(signer, as_asn1, "tst_info", digest) != (True, True):
        raise ValueError("its signature is of something else")


def _signer(certificates: Iterable[x509.Certificate], named: Any) -> x509.Certificate:
    """Return the certificate that a token's signer names by issuer and number."""
    for one in certificates:
        if (
            one.issuer.public_bytes() == named["issuer"].dump()
            and one.serial_number == named["serial_number"].native
        ):
            return one
    raise ValueError("it has no certificate of its service")
