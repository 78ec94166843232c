"""PAdES of a PDF (EN 319 142-1, B-B or, with a time stamp, B-T): a certifying signature that allows no change.

A PDF can be changed by what is appended to it. One that is signed here has nothing behind its signature; a
signature must cover every byte of the file but its own, or the file is refused.
"""

import hashlib
import logging
from io import BytesIO
from typing import Any

from asn1crypto import cms, tsp
from asn1crypto import x509 as asn1_x509
from asn1crypto.core import VOID
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, padding
from cryptography.hazmat.primitives.serialization import Encoding
from pyhanko.pdf_utils.generic import IndirectObject
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.pdf_utils.misc import PdfError
from pyhanko.pdf_utils.reader import PdfFileReader
from pyhanko.sign.fields import MDPPerm, SigSeedSubFilter, enumerate_sig_fields
from pyhanko.sign.general import SigningError
from pyhanko.sign.signers import PdfSignatureMetadata, PdfSigner, Signer
from pyhanko.sign.timestamps import TimeStamper
from pyhanko.sign.timestamps.common_utils import TimestampRequestError
from pyhanko.sign.validation.generic_cms import validate_sig_integrity
from pyhanko.sign.validation.pdf_embedded import EmbeddedPdfSignature
from pyhanko_certvalidator.registry import SimpleCertificateStore

from procedures.errors import ErrorCode
from station.errors import DataRefused, NoTimeStamp, SignatureBroken, refused_as
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.time_stamp import ask_service, granted
from station.results.certificate.signing.xml_signature import Signed

FIELD = "Laboratory"
RSA_BYTES_MOST = 1024  # room left for a signature before it is made: 8192 bit


class _KeyOfTheLaboratory(Signer):
    """Signs what pyHanko gives it with the laboratory's key."""

    def __init__(self, key: SigningKey) -> None:
        certificates = [
            asn1_x509.Certificate.load(one.public_bytes(Encoding.DER)) for one in (key.certificate, *key.others)
        ]
        registry = SimpleCertificateStore.from_certs(certificates[1:])  # type: ignore[no-untyped-call]
        mechanism = cms.SignedDigestAlgorithm({"algorithm": "sha256_rsa" if key.is_rsa else "sha256_ecdsa"})
        super().__init__(signing_cert=certificates[0], cert_registry=registry, signature_mechanism=mechanism)
        self._key: Any = key.private
        self._is_rsa = key.is_rsa

    async def async_sign_raw(self, data: bytes, digest_algorithm: str, dry_run: bool = False) -> bytes:
        """Return a signature of some bytes, of a dry run as many bytes as it may have."""
        if dry_run:
            return bytes(RSA_BYTES_MOST)
        form = (padding.PKCS1v15(), hashes.SHA256()) if self._is_rsa else (ec.ECDSA(hashes.SHA256()),)
        signed: bytes = self._key.sign(data, *form)
        return signed


class _Service(TimeStamper):
    """Asks a time-stamping service as `ask_service` does."""

    def __init__(self, url: str) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self._url = url

    async def async_request_tsa_response(self, req: tsp.TimeStampReq) -> tsp.TimeStampResp:
        """Return what the service answers."""
        answer = ask_service(self._url, req.dump())
        granted(self._url, answer)
        return tsp.TimeStampResp.load(answer)


def sign_pdf(pdf: bytes, key: SigningKey, time_service: str | None = None) -> bytes:
    """Return a PDF with a signature over all of its bytes, with a time stamp where a service's address is given.

    Raise `DataRefused` if it is no PDF that can be signed, or is signed already; `NoTimeStamp` if the service
    gives none.
    """
    meta = PdfSignatureMetadata(
        field_name=FIELD, md_algorithm="sha256", subfilter=SigSeedSubFilter.PADES, certify=True,
        docmdp_permissions=MDPPerm.NO_CHANGES,
    )  # fmt: skip
    stamper = None if time_service is None else _Service(time_service)
    out = BytesIO()
    try:
        writer = IncrementalPdfFileWriter(BytesIO(pdf))
        if signatures_of(writer.prev):
            raise DataRefused(
                "PDF", None, "a signature in it", "none yet", "sign what was not", ErrorCode.SIGNATURE
            )
        PdfSigner(meta, _KeyOfTheLaboratory(key), timestamper=stamper).sign_pdf(writer, output=out)
    except TimestampRequestError as error:
        raise NoTimeStamp(str(time_service), " ".join(str(error).split())) from error
    except (PdfError, SigningError) as error:
        raise DataRefused("PDF", None, f"none that can be signed ({error})", "a whole one") from error
    return out.getvalue()


def signatures_of(reader: PdfFileReader) -> list[Any]:
    """Return every field of a PDF that holds a signature or a time stamp, of whatever kind."""
    return list(enumerate_sig_fields(reader, filled_status=True))


SUBFILTERS = ("/ETSI.CAdES.detached", "/adbe.pkcs7.detached")
logging.getLogger("pyhanko").addHandler(logging.NullHandler())  # it warns of what is refused here in a line
MOST_NODES = 1000  # of the tree of attached files: one that goes in a circle ends
HASHES = ("sha256", "sha384", "sha512")


def open_pdf(content: bytes) -> PdfFileReader:
    """Return a reader; raise `SignatureBroken` if the bytes are no PDF, or one that is encrypted."""
    with refused_as("no whole PDF"):
        reader = PdfFileReader(BytesIO(content))
        if reader.encrypted:
            raise SignatureBroken("found an encrypted PDF, expected one that can be read")
    return reader


def has_signature(reader: PdfFileReader) -> bool:
    """Return whether there is any signature in a PDF; raise `SignatureBroken` if that cannot be read."""
    with refused_as("no whole PDF"):
        return bool(signatures_of(reader))


def verified_pdf(content: bytes, reader: PdfFileReader) -> Signed:
    """Return what the one signature of a PDF covers: all of the file.

    Raise `SignatureBroken` if it does not hold, covers less, or there is more than one.
    """
    with refused_as("it does not hold"):
        found = signatures_of(reader)
        if len(found) != 1:
            raise SignatureBroken(f"found {len(found)} of them, expected one")
        name, _, field = found[0]
        signature = EmbeddedPdfSignature(reader, field, name)
        _refuse_gap(content, signature)
        certificate = _refuse_other(signature)
        others = [_certificate(one) for one in signature.other_embedded_certs]
        return Signed(content, certificate, tuple(others), _claimed(signature), *_token(signature))


def _refuse_gap(content: bytes, signature: EmbeddedPdfSignature) -> None:
    """Refuse a signature that leaves out more of the file than its own value and the zeros behind that."""
    begin, before, after, rest = (int(one) for one in signature.byte_range)
    gap = content[before:after]
    whole = begin == 0 and 0 < before < after and after + rest == len(content) and rest > 0
    if not whole or gap[:1] != b"<" or gap[-1:] != b">":
        raise SignatureBroken("found bytes that it does not cover, expected all of the file")
    held = bytes.fromhex(gap[1:-1].decode("ascii"))
    length = _der_length(held)
    value = cms.ContentInfo.load(held[:length], strict=True)
    parts = len(value["content_type"].dump()) + len(value["content"].dump())
    if held != signature.pkcs7_content or any(held[length:]) or parts != len(value.contents):
        raise SignatureBroken("found bytes behind its value, expected none")


def _der_length(held: bytes) -> int:
    """Return how many bytes the first object of DER has, its head with it: X.690, 8.1.3."""
    first = held[1]
    if first < 0x80:
        return 2 + first
    count = first & 0x7F
    return 2 + count + int.from_bytes(held[2 : 2 + count])


def _refuse_other(signature: EmbeddedPdfSignature) -> x509.Certificate:
    """Refuse a signature whose mathematics do not hold, and return its key's certificate."""
    if signature.sig_object_type != "/Sig" or signature.sig_object.get("/SubFilter") not in SUBFILTERS:
        raise SignatureBroken("found one of another form, expected PAdES")
    if signature.md_algorithm not in HASHES or signature.signed_data["encap_content_info"]["content"].native:
        raise SignatureBroken("found a weak or another hash, expected SHA-256 or longer")
    held = validate_sig_integrity(signature.signer_info, signature.signer_cert, "data", signature.compute_digest())
    if held != (True, True):
        raise SignatureBroken("it does not hold: the file was changed")
    _check_named(signature)
    return _certificate(signature.signer_cert)


def _check_named(signature: EmbeddedPdfSignature) -> None:
    """Refuse a signature whose signed attributes name another certificate than it brings: ESS, RFC 5035."""
    named = {one["type"].native: one["values"] for one in signature.signer_info["signed_attrs"]}
    if "signing_certificate_v2" not in named:
        if signature.sig_object["/SubFilter"] == SUBFILTERS[0]:
            raise SignatureBroken("found no certificate named in what is signed, expected the key's")
        return
    first = named["signing_certificate_v2"][0]["certs"][0]
    algorithm = first["hash_algorithm"]["algorithm"].native
    digest = hashlib.new(algorithm, signature.signer_cert.dump()).digest()
    if algorithm not in HASHES or digest != first["cert_hash"].native:
        raise SignatureBroken("found another certificate than is named in what is signed")


def _token(signature: EmbeddedPdfSignature) -> tuple[bytes | None, bytes]:
    """Return the token of a signature's time stamp, None where it has none, and what it is over."""
    stamped: bytes = signature.signer_info["signature"].native
    attributes = signature.signer_info["unsigned_attrs"]
    if attributes is VOID:
        return None, stamped
    found = [one["values"] for one in attributes if one["type"].native == "signature_time_stamp_token"]
    tokens = [token.dump() for values in found for token in values]
    if len(tokens) > 1:
        raise SignatureBroken(f"found {len(tokens)} time stamps of it, expected one at most")
    return (tokens[0] if tokens else None), stamped


def _certificate(one: asn1_x509.Certificate) -> x509.Certificate:
    return x509.load_der_x509_certificate(one.dump())


def _claimed(signature: EmbeddedPdfSignature) -> str:
    at: Any = signature.self_reported_timestamp
    return "" if at is None else str(at.isoformat())


def attached_files(reader: PdfFileReader) -> dict[str, bytes]:
    """Return the files attached to a PDF by their names.

    Raise `SignatureBroken` if they cannot be read, or two have one name.
    """
    found = dict[str, bytes]()
    with refused_as("the attached files cannot be read"):
        names = _own(reader.root.get("/Names", {}))
        nodes = [_own(names.get("/EmbeddedFiles", {}))]
        for _ in range(MOST_NODES):
            if not nodes:
                break
            node = nodes.pop()
            nodes += _members(node.get("/Kids", []))
            for spec in _members(node.get("/Names", []))[1::2]:
                name = str(spec.get("/UF", spec.get("/F")))
                if name in found:
                    raise SignatureBroken(f"found two attached files {name!r}, expected each once")
                found[name] = bytes(_own(_own(spec["/EF"])["/F"]).data)
    return found


def _members(array: Any) -> list[Any]:
    """Return the members of an array themselves, not references to them."""
    return [_own(one) for one in _own(array)]


def _own(one: Any) -> Any:
    return one.get_object() if isinstance(one, IndirectObject) else one  # type: ignore[no-untyped-call]
