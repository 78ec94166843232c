"""PAdES of a PDF (EN 319 142-1, B-B or, with a time stamp, B-T): a certifying signature that allows no change."""

from io import BytesIO
from typing import Any

from asn1crypto import cms, tsp
from asn1crypto import x509 as asn1_x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, padding
from cryptography.hazmat.primitives.serialization import Encoding
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.pdf_utils.misc import PdfError
from pyhanko.pdf_utils.reader import PdfFileReader
from pyhanko.sign.fields import MDPPerm, SigSeedSubFilter, enumerate_sig_fields
from pyhanko.sign.general import SigningError
from pyhanko.sign.signers import PdfSignatureMetadata, PdfSigner, Signer
from pyhanko.sign.timestamps import TimeStamper
from pyhanko.sign.timestamps.common_utils import TimestampRequestError
from pyhanko_certvalidator.registry import SimpleCertificateStore

from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.results.certificate.signing.errors import NoTimeStamp
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.time_stamp import ask_service, granted

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

    Raises
    ------
    DataRefused
        If it is no PDF that can be signed, or is signed already.
    NoTimeStamp
        If the service gives none.
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
