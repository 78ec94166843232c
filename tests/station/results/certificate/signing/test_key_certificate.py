"""Whose key it is: trusted, expired, not yet valid, revoked, of another root, self-made: said as that."""

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from station.errors import DataRefused
from station.results.certificate.signing.key_certificate import Standing, Trust, read_trust, standing
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import (
    Owner,
    issue,
    laboratory,
    revocations,
    root,
    rsa_key,
)

NOW = datetime.now(UTC)
STRANGER = "CN=Root of others"


def stranger() -> Owner:
    return issue("Root of others", rsa_key(3), is_authority=True)


def between() -> Owner:
    return issue("Between", rsa_key(4), root(), is_authority=True)


CASES: dict[str, tuple[Callable[[], Owner], bool, str]] = {
    "trusted": (laboratory, True, "trusted by CN=Root of tests, no revocation list checked"),
    "expired": (lambda: issue("Old", rsa_key(1), root(), begins=-20, days=10), False, "expired"),
    "not yet": (lambda: issue("New", rsa_key(1), root(), begins=10), False, "not yet valid"),
    "self-made": (lambda: issue("Own", rsa_key(1)), False, "self-signed, not trusted"),
    "of others": (lambda: issue("X", rsa_key(1), stranger()), False, f"not trusted: {STRANGER} leads to no"),
    "a forged root": (
        lambda: issue("X", rsa_key(1), issue("Root of tests", rsa_key(3), is_authority=True)),
        False,
        "not trusted",
    ),
    "by no authority": (lambda: issue("X", rsa_key(3), laboratory()), False, "not trusted"),
    "of another use": (lambda: issue("X", rsa_key(1), root(), signs=False), False, "not allowed for signatures"),
}  # fmt: skip


def judged(owner: Owner, *others: Owner, trust: Trust | None = None, moment: datetime = NOW) -> Standing:
    return standing(
        owner.certificate, [one.certificate for one in others],
        Trust((root().certificate,)) if trust is None else trust, moment,
    )  # fmt: skip


def listed(content: bytes) -> Trust:
    return Trust((root().certificate,), (x509.load_pem_x509_crl(content),))


@pytest.mark.parametrize("name", CASES)
def test_a_key_is_reported_as_what_it_is(name: str) -> None:
    make, is_trusted, words = CASES[name]
    found = judged(make(), laboratory())
    assert found.is_trusted is is_trusted
    assert found.words.startswith(words)


def test_a_self_made_key_is_trusted_where_it_is_given() -> None:
    own = issue("Own", rsa_key(1))
    assert judged(own, trust=Trust((own.certificate,))) == Standing(True, "self-signed, trusted as given")


def test_an_authority_between_is_found_in_what_came_with_it() -> None:
    middle = between()
    below = issue("Below", rsa_key(5), middle)
    assert judged(below, middle).is_trusted
    assert not judged(below).is_trusted


def test_what_was_revoked_before_it_signed_is_revoked_and_afterwards_not() -> None:
    trust = listed(revocations(root(), laboratory(), at=NOW - timedelta(days=2)))
    assert judged(laboratory(), trust=trust).words.startswith("revoked on ")
    early = issue("Early", rsa_key(1), root(), begins=-30)
    trust = listed(revocations(root(), early, at=NOW - timedelta(days=2)))
    assert judged(early, trust=trust, moment=NOW - timedelta(days=10)).is_trusted
    assert not judged(early, trust=trust).is_trusted


def test_an_authority_between_may_be_revoked() -> None:
    middle = between()
    trust = listed(revocations(root(), middle))
    assert judged(issue("Below", rsa_key(5), middle), middle, trust=trust).words.startswith("revoked on ")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (lambda: revocations(stranger()), "not checked against a revocation list: none given is from its issuer"),
        (lambda: revocations(issue("Root of tests", rsa_key(3), is_authority=True)), "not checked against a"),
        (lambda: revocations(root(), days=-2), "not checked: the revocation list given ended "),
    ],
)
def test_a_list_that_says_nothing_of_it_is_no_list(content: Callable[[], bytes], words: str) -> None:
    found = judged(laboratory(), trust=listed(content()))
    assert not found.is_trusted
    assert found.words.startswith(words)


def test_roots_and_lists_are_read_from_files(tmp_path: Path) -> None:
    pem, crl = root().pem(tmp_path, "root"), tmp_path / "list.pem"
    crl.write_bytes(revocations(root()))
    assert read_trust([pem], [crl]).roots == (root().certificate,)
    der = tmp_path / "root.der"
    der.write_bytes(root().certificate.public_bytes(Encoding.DER))
    assert read_trust([der], []).roots == (root().certificate,)
    for file in (pem, crl):  # as openssl writes it: what it says in words, then the block
        file.write_bytes(b"Certificate:\n    Data:\n" + file.read_bytes())
    assert read_trust([pem], [crl]).roots == (root().certificate,)
    for roots, lists in (([crl], []), ([], [pem]), ([tmp_path / "none"], [])):
        with refused(DataRefused):
            read_trust(roots, lists)


EARLY, LATE = timedelta(seconds=-1), timedelta(seconds=1)


@pytest.mark.parametrize(
    ("end", "by", "words"),
    [
        ("begin", EARLY, "not yet valid"),
        ("begin", timedelta(0), "trusted by "),
        ("end", timedelta(0), "trusted by "),
        ("end", LATE, "expired"),
    ],
)
def test_a_certificate_holds_from_its_first_second_to_its_last(end: str, by: timedelta, words: str) -> None:
    known = laboratory().certificate
    moment = known.not_valid_before_utc if end == "begin" else known.not_valid_after_utc
    assert judged(laboratory(), moment=moment + by).words.startswith(words)


@pytest.mark.parametrize(
    ("by", "is_trusted"), [(timedelta(0), False), (timedelta(seconds=1), False), (timedelta(seconds=-1), True)]
)
def test_who_signs_at_the_second_of_the_revocation_is_revoked(by: timedelta, is_trusted: bool) -> None:
    at = NOW.replace(microsecond=0) - timedelta(hours=3)
    trust = listed(revocations(root(), laboratory(), at=at))
    words = "trusted by CN=Root of tests" if is_trusted else f"revoked on {at:%Y-%m-%d}"
    assert judged(laboratory(), trust=trust, moment=at + by) == Standing(is_trusted, words)


def test_a_service_revoked_after_it_stamped_is_revoked_and_needs_no_list_of_its_issuer() -> None:
    known, then = laboratory().certificate, NOW - timedelta(hours=20)
    revoked = listed(revocations(root(), laboratory(), at=NOW - timedelta(hours=2)))
    for is_service in (False, True):
        found = standing(known, [], revoked, then, is_service=is_service)
        assert found.is_trusted is not is_service
    other = listed(revocations(stranger()))
    assert not standing(known, [], other, then).is_trusted
    found = standing(known, [], other, then, is_service=True)
    assert found == Standing(True, "trusted by CN=Root of tests, no revocation list checked")
