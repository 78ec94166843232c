"""Whose key it is, and whether that may be believed: path to a trusted root, validity, revocation; no network.

A path is found by RFC 5280 (pyhanko-certvalidator). Revocation is read from lists that are given as files.
"""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

from asn1crypto import x509 as asn1_x509
from cryptography import x509
from cryptography.exceptions import UnsupportedAlgorithm
from cryptography.hazmat.primitives.serialization import Encoding
from pyhanko_certvalidator import CertificateValidator, ValidationContext
from pyhanko_certvalidator.errors import PathBuildingError, PathError, ValidationError
from pyhanko_certvalidator.path import ValidationPath

from station.errors import DataRefused, first_line
from station.files.toml_file import read_text_file
from station.results.certificate.signing.signing_key import may_sign

PEM_MARK = b"-----BEGIN"


@dataclass(frozen=True, slots=True)
class Trust:
    """What is trusted: certificates of roots, and lists of what they and those below them revoked."""

    roots: tuple[x509.Certificate, ...] = ()
    revoked: tuple[x509.CertificateRevocationList, ...] = ()


@dataclass(frozen=True, slots=True)
class Standing:
    """Whether a certificate is believed, and why or why not, in words."""

    is_trusted: bool
    words: str


def read_trust(roots: Sequence[Path], lists: Sequence[Path]) -> Trust:
    """Return certificates and revocation lists of files, PEM or DER; raise `DataRefused` where one is neither."""
    found, revoked = list[x509.Certificate](), list[x509.CertificateRevocationList]()
    for path in roots:
        content = read_text_file(path)
        try:
            many = PEM_MARK in content  # text may stand before it, as `openssl x509 -text` writes
            found += (
                x509.load_pem_x509_certificates(content) if many else [x509.load_der_x509_certificate(content)]
            )
        except (ValueError, x509.InvalidVersion) as error:
            raise DataRefused(path, None, "no certificate", "one or more, PEM, or one, DER") from error
    for path in lists:
        content = read_text_file(path)
        load = x509.load_pem_x509_crl if PEM_MARK in content else x509.load_der_x509_crl
        try:
            revoked.append(load(content))
        except ValueError as error:
            raise DataRefused(path, None, "no revocation list", "one, PEM or DER") from error
    return Trust(tuple(found), tuple(revoked))


def subject(certificate: x509.Certificate) -> str:
    """Return whose a certificate is, with the days on which it holds."""
    name = certificate.subject.rfc4514_string() or "nobody named"
    return (
        f"{name}, valid {certificate.not_valid_before_utc:%Y-%m-%d} to {certificate.not_valid_after_utc:%Y-%m-%d}"
    )


def standing(
    certificate: x509.Certificate,
    others: Sequence[x509.Certificate],
    trust: Trust,
    moment: datetime,
    *,
    is_service: bool = False,
) -> Standing:
    """Judge a certificate at the moment of its signature, or today where no time stamp says when that was.

    ``others`` are what came with it: they may be on the path to a root, and none of them is believed for that. A
    time-stamping service that was revoked at any time may have dated back, and no list of its issuer is asked for.
    """
    try:
        return _judged(certificate, others, trust, moment, is_service)
    except (ValueError, TypeError, UnsupportedAlgorithm, x509.DuplicateExtension, x509.InvalidVersion) as error:
        return Standing(False, f"not readable ({first_line(error)})")


def _judged(
    certificate: x509.Certificate,
    others: Sequence[x509.Certificate],
    trust: Trust,
    moment: datetime,
    is_service: bool,
) -> Standing:
    if not certificate.not_valid_before_utc <= moment <= certificate.not_valid_after_utc:
        return Standing(False, "expired" if moment > certificate.not_valid_after_utc else "not yet valid")
    if not may_sign(certificate):
        return Standing(False, "not allowed for signatures by its key usage")
    if certificate.issuer == certificate.subject:
        is_known = certificate in trust.roots
        return Standing(is_known, "self-signed, trusted as given" if is_known else "self-signed, not trusted")
    if not trust.roots:
        return Standing(False, f"not trusted: issued by {_issuer(certificate)}, no trusted root is given")
    try:
        path = _path(certificate, others, trust, moment)
    except PathBuildingError:
        return Standing(False, f"not trusted: {_issuer(certificate)} leads to no trusted root")
    except (PathError, ValidationError) as error:
        return Standing(False, f"not trusted: {' '.join(str(error).split())}")
    found = _revocation(path, trust, datetime.now(UTC) if is_service else moment)
    if found is None and trust.revoked and not is_service:
        return Standing(False, "not checked against a revocation list: none given is from its issuer")
    if found:
        return Standing(False, found)
    by = f"trusted by {path[-1].subject.rfc4514_string()}"
    return Standing(True, by if found == "" else f"{by}, no revocation list checked")


def _issuer(certificate: x509.Certificate) -> str:
    return certificate.issuer.rfc4514_string() or "nobody named"


def _path(
    certificate: x509.Certificate, others: Sequence[x509.Certificate], trust: Trust, moment: datetime
) -> list[x509.Certificate]:
    """Return the certificates from a key's own to a trusted root."""
    context = ValidationContext(
        trust_roots=[_asn1(one) for one in trust.roots], moment=moment, allow_fetching=False,
        other_certs=[_asn1(one) for one in others],
    )  # fmt: skip
    validator = CertificateValidator(_asn1(certificate), validation_context=context)
    found: ValidationPath = asyncio.run(validator.async_validate_path())
    authority = found.trust_anchor.authority
    root = [_asn1(one) for one in trust.roots if one.subject.public_bytes() == authority.name.dump()][:1]
    below = [one for one in found if isinstance(one, asn1_x509.Certificate) and one.dump() != root[0].dump()]
    return [x509.load_der_x509_certificate(one.dump()) for one in [*reversed(below), *root]]


def _asn1(certificate: x509.Certificate) -> asn1_x509.Certificate:
    return asn1_x509.Certificate.load(certificate.public_bytes(Encoding.DER))


def _revocation(path: Sequence[x509.Certificate], trust: Trust, moment: datetime) -> str | None:
    """Return how a certificate of a path was revoked by then, empty if none was, None where no list is of them."""
    seen = False
    for one, issuer in pairwise(path):
        for listed in trust.revoked:
            key: Any = issuer.public_key()
            if listed.issuer != one.issuer or not listed.is_signature_valid(key):
                continue  # not this issuer's, whatever its name says
            ends = listed.next_update_utc
            if ends is not None and ends < datetime.now(UTC):
                return f"not checked: the revocation list given ended {ends:%Y-%m-%d}"
            seen = seen or one is path[0]
            entry = listed.get_revoked_certificate_by_serial_number(one.serial_number)
            if entry is not None and entry.revocation_date_utc <= moment:
                return f"revoked on {entry.revocation_date_utc:%Y-%m-%d}"
    return "" if seen else None
