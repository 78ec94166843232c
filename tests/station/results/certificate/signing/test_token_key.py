"""A key on a token signs XML and PDF, here on SoftHSM; wrong PIN, token and key are refused."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.results.certificate.signing.pdf_signature import sign_pdf
from station.results.certificate.signing.verification import verify_pdf, verify_xml
from station.results.certificate.signing.xml_signature import sign_xml
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import Owner, issue, laboratory, root
from tests.station.results.certificate.signing.signed_files import pdf_with, trusted
from tests.station.results.certificate.signing.small_dcc import small_dcc

MODULE = Path("/usr/lib/softhsm/libsofthsm2.so")
URI = f"pkcs11:token=LAB;object={{}}?module-path={MODULE}"
PIN = b"4711"
pytest.importorskip("pkcs11")
pytestmark = pytest.mark.skipif(
    not MODULE.exists() or shutil.which("softhsm2-util") is None, reason="no SoftHSM here"
)


@pytest.fixture(scope="module")
def token(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    folder = tmp_path_factory.mktemp("hsm")
    (folder / "conf").write_text(
        f"directories.tokendir = {folder}\nobjectstore.backend = file\nlog.level = ERROR\n"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOFTHSM2_CONF", str(folder / "conf"))
        run("--init-token", "--free", "--label", "LAB", "--so-pin", "0815", "--pin", PIN.decode())
        curve = issue("EC", ec.generate_private_key(ec.SECP256R1()), root())
        for number, (name, owner) in enumerate({"rsa": laboratory(), "ec": curve}.items(), 1):
            pem = str(owner.key_pem(folder, name))
            run("--import", pem, "--token", "LAB", "--label", name, "--id", f"{number:02}", "--pin", PIN.decode())
            put_certificate(owner, name, number)
        old = issue("Old", ec.generate_private_key(ec.SECP256R1()), root(), begins=-20, days=10)
        for number, label in enumerate(("old", "bare"), 3):
            pem = str(old.key_pem(folder, label))
            run("--import", pem, "--token", "LAB", "--label", label, "--id", f"{number:02}", "--pin", PIN.decode())
        put_certificate(old, "old", 3)
        yield


def run(*arguments: str) -> None:
    subprocess.run(["softhsm2-util", *arguments], check=True, capture_output=True)


def put_certificate(owner: Owner, name: str, number: int) -> None:
    import pkcs11

    with pkcs11.lib(str(MODULE)).get_token(token_label="LAB").open(rw=True, user_pin=PIN.decode()) as session:
        session.create_object(
            {
                pkcs11.Attribute.CLASS: pkcs11.ObjectClass.CERTIFICATE,
                pkcs11.Attribute.CERTIFICATE_TYPE: pkcs11.CertificateType.X_509,
                pkcs11.Attribute.TOKEN: True,
                pkcs11.Attribute.LABEL: name,
                pkcs11.Attribute.ID: bytes([number]),
                pkcs11.Attribute.SUBJECT: owner.certificate.subject.public_bytes(),
                pkcs11.Attribute.VALUE: owner.certificate.public_bytes(Encoding.DER),
            }
        )


def opened(name: str, pin: bytes = PIN) -> Callable[..., object]:
    from station.results.certificate.signing.token_key import open_token_key

    return open_token_key(URI.format(name), pin)


@pytest.mark.parametrize("name", ["rsa", "ec"])
def test_a_key_on_a_token_signs(token: None, name: str) -> None:
    key = opened(name)
    try:
        found = verify_xml(sign_xml(small_dcc(), key), "signed", trusted())
        assert not found.faults
        pdf = verify_pdf(sign_pdf(pdf_with(small_dcc()), key), "signed", trusted())
        assert not pdf.faults
    finally:
        key.close()


def test_another_pin_is_refused_without_saying_it(token: None) -> None:
    with refused(DataRefused, ErrorCode.KEY) as caught:
        opened("rsa", b"123456")
    assert "123456" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "reported"),
    [
        ("none", "found no key of that name"),
        ("old", "expected one that is valid today"),
        ("bare", "found 0 certificates"),
    ],
)
def test_a_key_that_is_not_there_or_cannot_sign_is_refused(token: None, name: str, reported: str) -> None:
    with refused(DataRefused, ErrorCode.KEY, reported):
        opened(name)


@pytest.mark.parametrize("uri", ["lab", "pkcs11:token=LAB", f"pkcs11:token=OTHER;object=rsa?module-path={MODULE}"])
def test_an_address_of_no_token_is_refused(token: None, uri: str) -> None:
    from station.results.certificate.signing.token_key import open_token_key

    with refused(DataRefused, ErrorCode.KEY):
        open_token_key(uri, PIN)
