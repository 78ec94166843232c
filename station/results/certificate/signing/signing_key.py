"""The laboratory's key: from a PKCS#12 file, its password asked for and kept nowhere."""

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from getpass import getpass
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization.pkcs12 import load_key_and_certificates

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.toml_file import read_text_file

PrivateKey = rsa.RSAPrivateKey | ec.EllipticCurvePrivateKey
LEAST_RSA_BITS = 2048  # NIST SP 800-131A rev. 2, table 2
CURVES = ("secp256r1", "secp384r1", "secp521r1")  # those that XML signatures name


@dataclass(frozen=True, slots=True)
class SigningKey:
    """A private key, its certificate, and those of the authorities above it as far as the file has them."""

    private: PrivateKey = field(repr=False)
    certificate: x509.Certificate
    others: tuple[x509.Certificate, ...]
    close: Callable[[], None] = lambda: None  # of a token: leave it

    @property
    def is_rsa(self) -> bool:
        """Whether it is an RSA key, else one of an elliptic curve."""
        return isinstance(self.certificate.public_key(), rsa.RSAPublicKey)


def read_signing_key(path: Path, password: bytes | None) -> SigningKey:
    """Return the key of a PKCS#12 file.

    Raise `DataRefused` if the password is wrong, the file none, its key weak or of no kind that is used, its
    certificate not the key's, not for signatures, or not valid today.
    """
    content = read_text_file(path)
    try:
        private, certificate, others = load_key_and_certificates(content, password)
    except (ValueError, TypeError) as error:
        found = "no PKCS#12 file, or another password"
        raise no_key(path, found, "a key with its certificate", "give the file's password") from error
    if certificate is None or not isinstance(private, rsa.RSAPrivateKey | ec.EllipticCurvePrivateKey):
        raise no_key(path, "no RSA or EC key with its certificate", "both in one PKCS#12 file")
    key = SigningKey(private, certificate, tuple(others))
    check_signing_key(key, path)
    return key


def no_key(where: str | Path, found: str, expected: str, remedy: str = "correct the file") -> DataRefused:
    """Return the refusal of a key."""
    return DataRefused(where, None, found, expected, remedy, ErrorCode.KEY)


def refuse_no_key(path: Path) -> None:
    """Raise `DataRefused` if there is no such file."""
    if not path.is_file():
        expected, remedy = "a PKCS#12 file with key and certificate", "name the one that is there"
        raise DataRefused(path, None, "no such file", expected, remedy, ErrorCode.FILE_MISSING)


def check_signing_key(key: SigningKey, where: str | Path) -> None:
    """Raise `DataRefused` if a key cannot sign a certificate today."""
    for found, expected in _faults(key):
        key.close()
        raise no_key(where, found, expected, "use another key")


def _faults(key: SigningKey) -> list[tuple[str, str]]:
    """Return what is wrong with a key, each as found and expected."""
    found, certificate = list[tuple[str, str]](), key.certificate
    public = certificate.public_key()
    if key.private.public_key() != public:
        found.append(("a certificate of another key", "that of the key"))
    elif isinstance(public, rsa.RSAPublicKey):
        if public.key_size < LEAST_RSA_BITS:
            found.append((f"an RSA key of {public.key_size} bit", f"{LEAST_RSA_BITS} bit or more"))
    elif not isinstance(public, ec.EllipticCurvePublicKey) or public.curve.name not in CURVES:
        name = getattr(getattr(public, "curve", None), "name", "no curve")
        found.append((f"a key of curve {name}", f"one of {', '.join(CURVES)}"))
    now = datetime.now(UTC)
    if not certificate.not_valid_before_utc <= now <= certificate.not_valid_after_utc:
        span = f"{certificate.not_valid_before_utc:%Y-%m-%d} to {certificate.not_valid_after_utc:%Y-%m-%d}"
        found.append((f"a certificate valid from {span}", "one that is valid today"))
    if not may_sign(certificate):
        found.append(("a certificate that is not for signatures", "key usage digitalSignature or nonRepudiation"))
    return found


def may_sign(certificate: x509.Certificate) -> bool:
    """Return whether a certificate's key usage, if it states one, allows signatures of documents."""
    try:
        usage = certificate.extensions.get_extension_for_class(x509.KeyUsage).value
    except x509.ExtensionNotFound:
        return True
    return usage.digital_signature or usage.content_commitment


def key_password(
    path: str | Path, descriptor: int | None, variable: str | None, ask: Callable[[str], str] = getpass
) -> bytes:
    """Return a key's password: from an open file descriptor, an environment variable, or asked for.

    Raise `DataRefused` if descriptor or variable is not there, or nobody can be asked: there is no terminal.
    """
    if descriptor is not None:
        try:
            with os.fdopen(descriptor, "rb", closefd=False) as stream:
                return stream.readline(4096).rstrip(b"\r\n")
        except (OSError, ValueError, TypeError, OverflowError) as error:  # closed, negative, beyond any descriptor
            found, remedy = f"no open descriptor {descriptor}", "open it for the station"
            raise no_key(path, found, "one with the password", remedy) from error
    if variable is not None:
        if variable not in os.environ:
            raise no_key(path, f"no variable {variable}", "the password in it", "set it")
        return os.fsencode(os.environ[variable])  # the bytes as they were set
    if not sys.stdin.isatty():
        remedy = "give --password-fd or --password-env"
        raise no_key(path, "no terminal to ask for its password", "one", remedy)
    return os.fsencode(ask(f"Password of {path}: "))
