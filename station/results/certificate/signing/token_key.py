"""The laboratory's key on a token (PKCS#11): it signs there and never leaves it.

A token is named by its URI, RFC 7512:
``pkcs11:token=LAB;object=signing?module-path=/usr/lib/softhsm/libsofthsm2.so``.
"""

from collections.abc import Mapping
from typing import Any
from urllib.parse import unquote

import pkcs11
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import rsa, utils

from station.errors import DataRefused, first_line
from station.results.certificate.signing.signing_key import SigningKey, check_signing_key, no_key

SCHEME = "pkcs11:"


class _OnToken:
    """A private key on a token with the methods by which signing asks a key in memory."""

    def __init__(self, private: Any, certificate: x509.Certificate) -> None:
        self._private, self._public = private, certificate.public_key()

    @property
    def key_size(self) -> int:
        """Bits of the key."""
        public: Any = self._public
        return int(public.key_size)

    def public_key(self) -> Any:
        """Return the certificate's: what is signed is verified by it before it is handed out."""
        return self._public

    def sign(self, data: bytes, *form: Any, **named: Any) -> bytes:
        """Return the signature of some bytes by SHA-256: RSA by PKCS#1 v1.5, of a curve as DER."""
        if isinstance(self._public, rsa.RSAPublicKey):
            return bytes(self._private.sign(data, mechanism=pkcs11.Mechanism.SHA256_RSA_PKCS))
        digest = hashes.Hash(hashes.SHA256())
        digest.update(data)
        raw = bytes(self._private.sign(digest.finalize(), mechanism=pkcs11.Mechanism.ECDSA))
        half = len(raw) // 2
        return utils.encode_dss_signature(int.from_bytes(raw[:half]), int.from_bytes(raw[half:]))


def open_token_key(uri: str, pin: bytes) -> SigningKey:
    """Return the key of a token, logged in to until the key is closed.

    Raise `DataRefused` if there is no such module, token or key, the PIN is wrong, or the key cannot sign a
    certificate.
    """
    named = _parts(uri)
    try:
        token = pkcs11.lib(named["module-path"]).get_token(token_label=named["token"])
        session = token.open(user_pin=pin.decode())
    except pkcs11.exceptions.PinIncorrect as error:
        raise no_key(uri, "another PIN", "that of the token", "give it; tokens lock after a few") from error
    except (pkcs11.exceptions.PKCS11Error, RuntimeError, OSError, UnicodeDecodeError) as error:
        raise no_key(uri, f"no such token ({first_line(error)})", "one that can be opened") from error
    try:
        private = session.get_key(object_class=pkcs11.ObjectClass.PRIVATE_KEY, label=named["object"])
        certificate, others = _certificates(session, private, uri)
    except (pkcs11.exceptions.PKCS11Error, ValueError) as error:
        session.close()
        if isinstance(error, DataRefused):
            raise
        raise no_key(uri, f"no key of that name ({first_line(error)})", "one on the token") from error
    on_token: Any = _OnToken(private, certificate)
    key = SigningKey(on_token, certificate, others, session.close)
    check_signing_key(key, uri)
    return key


def _parts(uri: str) -> Mapping[str, str]:
    """Return the attributes of a URI; raise `DataRefused` if one that is needed is not there."""
    text = uri.removeprefix(SCHEME).replace("?", ";").replace("&", ";").split(";")
    parts = {name: unquote(value) for name, _, value in (one.partition("=") for one in text)}
    lacking = {"token", "object", "module-path"} - parts.keys()
    if not uri.startswith(SCHEME) or lacking:
        example = "pkcs11:token=LAB;object=NAME?module-path=/usr/lib/MODULE.so"
        raise no_key(uri, f"no {', '.join(sorted(lacking)) or SCHEME}", example, "name the token so")
    return parts


def _certificates(session: Any, private: Any, uri: str) -> tuple[x509.Certificate, tuple[x509.Certificate, ...]]:
    """Return the certificate that has the key's id, and all others on the token."""
    kind = {pkcs11.Attribute.CLASS: pkcs11.ObjectClass.CERTIFICATE}
    by_id = [
        (one[pkcs11.Attribute.ID], x509.load_der_x509_certificate(one[pkcs11.Attribute.VALUE]))
        for one in session.get_objects(kind)
    ]
    own = [one for number, one in by_id if number == private[pkcs11.Attribute.ID]]
    if len(own) != 1:
        raise no_key(uri, f"{len(own)} certificates of the key's id on the token", "one")
    return own[0], tuple(one for _, one in by_id if one != own[0])
