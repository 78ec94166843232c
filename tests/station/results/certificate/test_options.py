"""Options of the command certificate: values and pairs that are refused, before anything is issued."""

from pathlib import Path

import pytest

from fixtures_db.database import Database
from fixtures_db.issued_certificates import issued_of
from station.results.certificate.issuing import find_calibration
from tests.station.results.certificate.conftest import Run, certify
from tests.station.results.certificate.factory import EXAMPLE

RAW = "caf\udce9"  # as an argument of the byte 0xe9 arrives


def issued(db: Database) -> int:
    with db.read() as session:
        return len(issued_of(session, find_calibration(session, "S0101").sha256))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--customer", ""), ("--customer", "x" * 1001), ("--customer", "a\tb"), ("--customer-address", "a\nb"),
        ("--customer-email", "a\x07b"), ("--condition", RAW),
    ],
)  # fmt: skip
def test_text_that_cannot_be_printed_is_refused_by_its_option(
    db: Database, station: Run, option: str, value: str
) -> None:
    code, _, error = certify(station, option, value)
    assert (code, issued(db)) == (3, 0)
    assert f"{option}: found " in error


@pytest.mark.parametrize("value", ["no address", "a@b@c", "@host", "name@", "a b@c"])
def test_an_email_has_one_at(db: Database, station: Run, value: str) -> None:
    code, _, error = certify(station, "--customer-email", value)
    assert (code, issued(db)) == (3, 0)
    assert "an address with one @" in error


@pytest.mark.parametrize(
    "line", ["temperature_c = [-400.0, 22.0]", "temperature_c = [21.0, 61.0]", "humidity_percent = [-5.0, 146.0]"]
)
def test_a_room_that_cannot_be_is_refused(db: Database, station: Run, tmp_path: Path, line: str) -> None:
    reported = (
        EXAMPLE.read_text().replace("[environment]", "[old]").partition("[old]")[0] + f"[environment]\n{line}\n"
    )
    (tmp_path / "lab.toml").write_text(reported)
    code, _, error = station("certificate", "S0101", "--laboratory", str(tmp_path / "lab.toml"))
    assert code == 3
    assert f"environment.{line.partition(' ')[0]}" in error


@pytest.mark.parametrize("url", ["notaurl", "ftp://time.example", "file:///etc/hosts", "http://", "http://[::1"])
def test_an_address_that_no_service_has_is_refused_first(db: Database, station: Run, url: str) -> None:
    code, _, error = certify(station, "--dcc", "--sign", "absent.p12", "--timestamp", url)
    assert (code, issued(db)) == (2, 0)
    assert "--timestamp: found " in error


@pytest.mark.parametrize("name", ["a.xml", "a.pdf", "a.PDF"])
def test_the_html_is_not_written_where_another_belongs(db: Database, station: Run, name: str) -> None:
    code, _, error = certify(station, "--out", name)
    assert (code, issued(db)) == (2, 0)
    assert "--out names the HTML" in error


@pytest.mark.parametrize(
    "option", ["--customer", "--customer-address", "--customer-email", "--condition", "--amend"]
)
def test_a_copy_says_what_was_issued(db: Database, station: Run, option: str) -> None:
    certify(station, "--out", "a.html")
    code, _, error = station("certificate", "S0101", "--copy", option, "x@y", "--out", "b.html")
    assert (code, Path("b.html").exists()) == (2, False)
    assert f"found {option}" in error
    assert "copy of certificate No. " in station("certificate", "S0101", "--copy", "--out", "b.html")[1]
