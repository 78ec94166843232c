"""Keys, certificates and revocation lists, made for a test and gone after it."""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    NoEncryption,
    PrivateFormat,
)
from cryptography.hazmat.primitives.serialization.pkcs12 import serialize_key_and_certificates
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

PASSWORD = b"of a test"
Private = rsa.RSAPrivateKey | ec.EllipticCurvePrivateKey


@dataclass(frozen=True)
class Owner:
    """A key and the certificate of it."""

    private: Private
    certificate: x509.Certificate

    def pem(self, folder: Path, name: str) -> Path:
        path = folder / f"{name}.pem"
        path.write_bytes(self.certificate.public_bytes(Encoding.PEM))
        return path

    def key_pem(self, folder: Path, name: str) -> Path:
        path = folder / f"{name}.key"
        kind = PrivateFormat.PKCS8
        path.write_bytes(self.private.private_bytes(Encoding.PEM, kind, NoEncryption()))
        return path

    def p12(self, folder: Path, name: str, *others: "Owner", password: bytes = PASSWORD) -> Path:
        path = folder / f"{name}.p12"
        certificates = [one.certificate for one in others]
        content = serialize_key_and_certificates(
            name.encode(), self.private, self.certificate, certificates, BestAvailableEncryption(password)
        )
        path.write_bytes(content)
        return path


@cache
def rsa_key(number: int = 0, bits: int = 2048) -> rsa.RSAPrivateKey:
    """The key of a number: making one takes a tenth of a second."""
    return rsa.generate_private_key(65537, bits)


def name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def issue(
    text: str, private: Private, issuer: Owner | None = None, *, is_authority: bool = False, days: int = 365,
    begins: int = -1, stamps: bool = False, signs: bool = True,
) -> Owner:  # fmt: skip
    """A certificate from ``begins`` days after now for ``days``; by itself without an issuer."""
    now = datetime.now(UTC).replace(microsecond=0)
    subject = name(text)
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject if issuer is None else issuer.certificate.subject)
        .public_key(private.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now + timedelta(days=begins))
        .not_valid_after(now + timedelta(days=begins + days))
        .add_extension(x509.BasicConstraints(is_authority, None), critical=True)
        .add_extension(usage(signs, is_authority), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(private.public_key()), critical=False)
    )
    if stamps:
        builder = builder.add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.TIME_STAMPING]), critical=True)
    signer = private if issuer is None else issuer.private
    return Owner(private, builder.sign(signer, hashes.SHA256()))


def usage(signs: bool, is_authority: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=signs, content_commitment=False, key_encipherment=not signs, data_encipherment=False,
        key_agreement=False, key_cert_sign=is_authority, crl_sign=is_authority, encipher_only=False,
        decipher_only=False,
    )  # fmt: skip


def revocations(issuer: Owner, *revoked: Owner, at: datetime | None = None, days: int = 30) -> bytes:
    """The issuer's list, PEM."""
    now = datetime.now(UTC).replace(microsecond=0)
    first = now - timedelta(days=60)
    builder = x509.CertificateRevocationListBuilder().issuer_name(issuer.certificate.subject)
    builder = builder.last_update(first).next_update(now + timedelta(days=days))
    for one in revoked:
        entry = x509.RevokedCertificateBuilder().serial_number(one.certificate.serial_number)
        builder = builder.add_revoked_certificate(entry.revocation_date(at or now - timedelta(hours=12)).build())
    return builder.sign(issuer.private, hashes.SHA256()).public_bytes(Encoding.PEM)


@cache
def root() -> Owner:
    return issue("Root of tests", rsa_key(0), is_authority=True, days=3650, begins=-1000)


@cache
def laboratory() -> Owner:
    return issue("Laboratory of tests", rsa_key(1), root())


@cache
def stamping_service() -> Owner:
    return issue("Time of tests", rsa_key(2), root(), stamps=True, days=3650, begins=-1000)
