"""Time stamps: got from a service on this machine, held to what they are of, refused where of something else."""

from collections.abc import Callable
from pathlib import Path

import pytest
from asn1crypto import core, tsp

from procedures.errors import ErrorCode
from station.errors import NoTimeStamp, SignatureBroken
from station.results.certificate.signing.signing_key import SigningKey
from station.results.certificate.signing.time_stamp import read_time_stamp, request_time_stamp
from station.results.certificate.signing.verification import verify_xml
from station.results.certificate.signing.xml_signature import sign_xml
from tests.refusals import refused
from tests.station.results.certificate.signing.authorities import issue, root, rsa_key, stamping_service
from tests.station.results.certificate.signing.signed_files import trusted
from tests.station.results.certificate.signing.small_dcc import small_dcc
from tests.station.results.certificate.signing.time_service import time_service


@pytest.fixture(scope="module")
def token(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    with time_service(tmp_path_factory.mktemp("time")) as url:
        return request_time_stamp(url, b"what was signed")


def test_a_token_says_when_and_by_whom(token: bytes) -> None:
    stamp = read_time_stamp(token, b"what was signed")
    assert stamp.certificate == stamping_service().certificate
    assert stamp.moment.tzinfo is not None


def test_a_token_of_something_else_is_refused(token: bytes) -> None:
    with refused(SignatureBroken, ErrorCode.SIGNATURE):
        read_time_stamp(token, b"another")


@pytest.mark.parametrize(
    "change", [lambda t: t[:-9] + bytes([t[-9] ^ 1]) + t[-8:], lambda t: t[:-30], lambda t: b"", lambda t: t * 2]
)
def test_a_changed_token_is_refused(token: bytes, change: Callable[[bytes], bytes]) -> None:
    with pytest.raises(SignatureBroken):
        read_time_stamp(change(token), b"what was signed")


REFUSED = core.Sequence(
    contents=tsp.PKIStatusInfo({"status": "rejection", "status_string": ["not today"]}).dump()
).dump()


@pytest.mark.parametrize(
    ("answer", "reported"),
    [(b"no answer", "no time stamp ("), (REFUSED, "rejection: not today"), (b"", "no time stamp (")],
)
def test_a_service_that_gives_none_is_named(tmp_path: Path, answer: bytes, reported: str) -> None:
    with time_service(tmp_path, answer) as url, pytest.raises(NoTimeStamp) as caught:
        request_time_stamp(url, b"what was signed")
    assert reported in str(caught.value)
    assert str(caught.value).startswith(url)
    assert "\n" not in str(caught.value)


def test_an_old_answer_is_refused(tmp_path: Path, token: bytes) -> None:
    status = {"status": {"status": "granted"}, "time_stamp_token": tsp.ContentInfo.load(token)}
    old = tsp.TimeStampResp(status).dump()
    with time_service(tmp_path, old) as url, refused(NoTimeStamp, ErrorCode.TIME_STAMP, url=url):
        request_time_stamp(url, b"what was signed")


def test_what_expired_after_it_was_stamped_still_holds(tmp_path: Path) -> None:
    short = issue("Short", rsa_key(1), root(), begins=-1, days=2)
    key = SigningKey(short.private, short.certificate, ())
    with time_service(tmp_path) as url:
        signed = sign_xml(small_dcc(), key, url)
    assert not verify_xml(signed, "signed", trusted()).faults


def test_an_expired_key_without_a_trusted_time_is_expired() -> None:
    old = issue("Old", rsa_key(1), root(), begins=-20, days=10)
    signed = sign_xml(small_dcc(), SigningKey(old.private, old.certificate, ()))
    faults = verify_xml(signed, "signed", trusted()).faults
    assert list(faults) == ["key"]
    assert faults["key"].endswith(": expired")
