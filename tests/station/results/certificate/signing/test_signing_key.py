"""The laboratory's key: read with its password, refused where it cannot sign, its password kept nowhere."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric import dsa, ec

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.results.certificate.signing.signing_key import key_password, read_signing_key
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import PASSWORD, Owner, issue, laboratory, root, rsa_key

REFUSED: dict[str, tuple[Callable[[], Owner], str]] = {
    "expired": (lambda: issue("Old", rsa_key(1), begins=-20, days=10), "expected one that is valid today"),
    "early": (lambda: issue("New", rsa_key(1), begins=10), "expected one that is valid today"),
    "short": (lambda: issue("Short", rsa_key(9, 1024)), "found an RSA key of 1024 bit, expected 2048 bit or more"),
    "curve": (lambda: issue("K1", ec.generate_private_key(ec.SECP256K1())), "found a key of curve secp256k1"),
    "use": (lambda: issue("TLS", rsa_key(1), signs=False), "key usage digitalSignature"),
    "another": (lambda: Owner(rsa_key(2), laboratory().certificate), ""),
}


def test_a_key_is_read_with_the_certificates_above_it(tmp_path: Path) -> None:
    key = read_signing_key(laboratory().p12(tmp_path, "lab", root()), PASSWORD)
    assert key.certificate == laboratory().certificate
    assert key.others == (root().certificate,)
    assert key.is_rsa
    assert "private" not in repr(key)


@pytest.mark.parametrize("password", [b"wrong", b"", None])
def test_another_password_is_refused_without_saying_it(tmp_path: Path, password: bytes | None) -> None:
    with refused(DataRefused, ErrorCode.KEY) as caught:
        read_signing_key(laboratory().p12(tmp_path, "lab"), password)
    assert "wrong" not in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", REFUSED)
def test_a_key_that_cannot_sign_a_certificate_is_refused(tmp_path: Path, name: str) -> None:
    make, reported = REFUSED[name]
    try:
        file = make().p12(tmp_path, "lab")
    except ValueError:  # the library makes none of two that do not belong together
        return
    with pytest.raises(DataRefused) as caught:
        read_signing_key(file, PASSWORD)
    assert reported in str(caught.value)


def test_a_key_of_another_kind_is_refused(tmp_path: Path) -> None:
    private = dsa.generate_private_key(2048)
    with refused(DataRefused, ErrorCode.KEY):
        read_signing_key(issue("DSA", private).p12(tmp_path, "lab"), PASSWORD)


def test_a_password_comes_from_a_descriptor_a_variable_or_a_person(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    os.write(writing, PASSWORD + b"\n")
    os.close(writing)
    assert key_password(Path("lab.p12"), reading, None) == PASSWORD
    os.close(reading)
    monkeypatch.setenv("OF_A_TEST", "secret")
    assert key_password(Path("lab.p12"), None, "OF_A_TEST") == b"secret"
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    assert key_password(Path("lab.p12"), None, None, ask=lambda text: text) == b"Password of lab.p12: "


@pytest.mark.parametrize(
    ("descriptor", "variable"), [(987, None), (-1, None), (10**14, None), (None, "NOT_SET_AT_ALL"), (None, None)]
)
def test_where_there_is_no_password_that_is_reported(descriptor: int | None, variable: str | None) -> None:
    with refused(DataRefused, ErrorCode.KEY, file="lab.p12"):
        key_password(Path("lab.p12"), descriptor, variable)
