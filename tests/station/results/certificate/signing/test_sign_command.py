"""`station certificate --dcc --sign`: signed, recorded, verified with and without the database."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from sqlalchemy import text

from fixtures_db.database import open_db
from station import cli
from tests.fixtures_db.factory import unprotect
from tests.station.results.certificate.factory import EXAMPLE, accepted
from tests.station.results.certificate.signing.authorities import PASSWORD, laboratory, root
from tests.station.results.certificate.signing.time_service import time_service

ORDER = (
    "--customer", "Sky AG", "--customer-address", "Town", "--customer-email", "imu@sky.example",
    "--received", "2026-03-02", "--condition", "good",
)  # fmt: skip
Run = Callable[..., tuple[int, str, str]]
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file .*sRGB2014:ResourceWarning")  # weasyprint leaves it


@pytest.fixture
def station(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("KEY_PASSWORD", PASSWORD.decode())
    laboratory().p12(tmp_path, "lab", root())
    root().pem(tmp_path, "root")
    with open_db(tmp_path / "station.db") as opened, opened.write() as session:
        accepted(session)

    def run(*arguments: str) -> tuple[int, str, str]:
        code = cli.run([*arguments, "--db", str(tmp_path / "station.db")])
        captured = capsys.readouterr()
        assert captured.err.count("\n") <= 1
        assert PASSWORD.decode() not in captured.out + captured.err
        return code, captured.out, captured.err

    return run


def certify(station: Run, *more: str) -> tuple[int, str, str]:
    signed = ("--sign", "lab.p12", "--password-env", "KEY_PASSWORD")
    return station("certificate", "S0101", "--laboratory", str(EXAMPLE), *ORDER, "--out", "c.html", *signed, *more)


def test_xml_and_pdf_are_signed_and_every_byte_is_known(station: Run, tmp_path: Path) -> None:
    with time_service(tmp_path / "time") as url:
        code, out, error = certify(station, "--dcc", "--pdf", "--timestamp", url)
    assert (code, error) == (0, "")
    assert "c.xml: signed, sha256 " in out
    for name in ("c.xml", "c.pdf"):
        code, out, error = station("verify", name, "--trust", "root.pem")
        assert (code, error) == (0, "")
        assert "trusted by CN=Root of tests" in out
        assert "every byte as signed on " in out
        assert "whole, from certificate " in out


def test_a_stamped_certificate_witnesses_the_journal(station: Run, tmp_path: Path) -> None:
    assert certify(station, "--dcc", "--pdf")[0] == 0
    code, _, error = station("verify", "--anchor", "c.xml", "--trust", "root.pem")
    assert (code, "c.xml: found no time stamp" in error) == (3, True)
    with time_service(tmp_path / "time") as url:
        assert certify(station, "--dcc", "--pdf", "--timestamp", url, "--amend", "late")[0] == 0
    for name in ("c.xml", "c.pdf"):
        assert ", stamped 20" in station("verify", name, "--trust", "root.pem")[1].split("\njournal", 1)[1]
        code, out, _ = station("verify", "--anchor", name, "--trust", "root.pem")
        assert code == 0
        assert re.search(rf"witnessed until entry \d+ by {name}, written .* by CN=Time of tests: trusted", out)
        code, _, error = station("verify", "--anchor", name)
        assert (code, "give --trust ROOT.pem" in error) == (1, True)
    content = (tmp_path / "c.xml").read_bytes()
    (tmp_path / "d.xml").write_bytes(re.sub(rb">\d+-[0-9a-f]{16}<", b">1-0123456789abcdef<", content))
    assert station("verify", "--anchor", "d.xml", "--trust", "root.pem")[0] == 1
    for old in tmp_path.glob("station.db*"):  # as if an older copy were put back
        old.unlink()
    open_db(tmp_path / "station.db").close()
    code, _, error = station("verify", "--anchor", "c.xml", "--trust", "root.pem")
    assert (code, "found none, expected " in error) == (1, True)


def test_a_certificate_whose_journal_is_another_is_reported(station: Run, tmp_path: Path) -> None:
    assert certify(station, "--dcc")[0] == 0
    assert "has entry " in station("verify", "c.xml", "--trust", "root.pem")[1]
    with open_db(tmp_path / "station.db") as database, database.write() as session:
        unprotect(session, "journal")
        session.execute(text("DELETE FROM journal WHERE id > 3"))
    code, out, error = station("verify", "c.xml", "--trust", "root.pem")
    assert (code, "journal" in error) == (1, True)
    assert "an older copy was restored, or the journal was restarted" in out


@pytest.mark.parametrize("name", ["c.xml", "c.pdf"])
def test_with_the_database_bytes_next_to_the_content_are_reported(station: Run, tmp_path: Path, name: str) -> None:
    assert certify(station, "--dcc", *(["--pdf"] if name == "c.pdf" else []))[0] == 0
    content = (tmp_path / name).read_bytes()
    changed = content.replace(b"<?xml version='1.0'", b"<?xml  version='1.0'") + b"\n" * (name == "c.pdf")
    (tmp_path / name).write_bytes(changed)
    code, _, error = station("verify", name, "--trust", "root.pem")
    assert code == 1
    if name == "c.xml":  # the document itself still holds
        assert "found database not the bytes of any file of certificate No. EX-" in error


def test_a_copy_may_be_signed_later(station: Run) -> None:
    ask = ("certificate", "S0101", "--laboratory", str(EXAMPLE), *ORDER, "--out", "c.html", "--dcc")
    assert station(*ask)[0] == 0
    again = ("certificate", "S0101", "--copy", "--dcc", "--out", "d.html", "--sign", "lab.p12")
    assert station(*again, "--password-env", "KEY_PASSWORD")[0] == 0
    code, out, _ = station("verify", "d.xml", "--trust", "root.pem")
    assert code == 0
    assert "content     as issued" in out


def test_another_password_costs_no_number(station: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("KEY_PASSWORD", "wrong")
    code, out, error = certify(station, "--dcc")
    assert (code, out) == (3, "")
    assert "give the file's password" in error
    assert not (tmp_path / "c.html").exists()


def test_a_service_that_is_not_there_leaves_what_was_issued(station: Run, tmp_path: Path) -> None:
    code, _, error = certify(station, "--dcc", "--timestamp", "http://127.0.0.1:9/")
    assert code == 4
    assert "http://127.0.0.1:9/: no time stamp" in error
    assert station("verify", "c.xml")[0] == 0  # as issued, without signature


def test_a_signed_file_gives_way_to_a_signed_one_alone(station: Run, tmp_path: Path) -> None:
    assert certify(station, "--dcc", "--pdf")[0] == 0
    names = ("c.xml", "c.pdf")
    before = [(tmp_path / name).read_bytes() for name in names]
    again = ("certificate", "S0101", "--copy", "--dcc", "--pdf", "--out", "c.html")
    code, out, error = station(*again)
    assert (code, out) == (2, "")
    assert "c.xml: cannot be written (a signed file exists" in error
    second_signature = ("--laboratory", str(EXAMPLE), *ORDER, "--amend", "name", "--dcc", "--out", "c.html")
    assert station("certificate", "S0101", *second_signature)[:2] == (2, "")  # and no number is given
    key = ("--sign", "lab.p12", "--password-env", "KEY_PASSWORD")
    code, out, _ = station(*again, *key, "--timestamp", "http://127.0.0.1:9/")
    assert code == 4
    assert "c.xml: not changed, it was signed before" in out
    assert [(tmp_path / name).read_bytes() for name in names] == before
    assert station(*again, *key)[0] == 0
    assert (tmp_path / "c.xml").read_bytes() != before[0]


@pytest.mark.parametrize("options", [("--timestamp", "http://x/"), ("--password-env", "X"), ("--sign", "lab.p12")])
def test_options_that_go_together_are_asked_for(station: Run, options: tuple[str, ...]) -> None:
    assert station("certificate", "S0101", "--laboratory", str(EXAMPLE), *ORDER, *options)[0] == 2
