"""`station certificate` and `station verify` of what it wrote, on a database of its own."""

import os
import re
import sys
from pathlib import Path

import pytest
from sqlalchemy import text

from fixtures_db.database import Database
from fixtures_db.errors import NotInDatabase
from fixtures_db.issued_certificates import issued_of
from station.results.certificate.issuing import find_calibration
from tests.fixtures_db.factory import fill_fixtures, unprotect
from tests.station.guide.recorded import die, killed
from tests.station.results.certificate.conftest import Run, certify
from tests.station.results.certificate.factory import accepted


def test_a_certificate_is_written_recorded_and_found(db: Database, station: Run, tmp_path: Path) -> None:
    code, out, _ = certify(station)
    assert code == 0
    [number] = re.findall(r"certificate No\. (EX-\d{4}-0001): sha256 [0-9a-f]{64}", out)
    file = tmp_path / f"{number}.html"
    code, out, _ = station("verify", str(file))
    assert (code, f"certificate No. {number}" in out) == (0, True)
    file.write_bytes(file.read_bytes().replace(b"S0101", b"S0102"))
    assert station("verify", str(file))[0] == 1
    assert station("verify")[0] == 0


def test_all_that_is_missing_is_reported_at_once(db: Database, station: Run, tmp_path: Path) -> None:
    bare = tmp_path / "lab.toml"
    bare.write_text('format = "laboratory/1"\n')
    code, out, error = station("certificate", "S0101", "--laboratory", str(bare))
    assert code == 3
    for field in ("laboratory.name", "authorised.function", "customer.address", "item.received", "time_base"):
        assert re.search(rf"missing +\S*{field}", out), field
        assert field in error
    assert list(tmp_path.glob("*.html")) == []
    with db.read() as session:
        assert issued_of(session, find_calibration(session, "S0101").sha256) == []


def test_issuing_again_wants_a_reason_and_replaces_what_was_issued(db: Database, station: Run) -> None:
    certify(station, "--out", "first.html")
    code, _, error = certify(station)
    assert code == 3
    assert "reason for replacing it (--amend TEXT: No. EX-" in error
    code, out, _ = certify(station, "--amend", "the address was wrong", "--out", "second.html")
    assert code == 0
    assert re.search(r"No\. EX-\d{4}-0002, replaces No\. EX-\d{4}-0001", out)
    assert "the address was wrong" in Path("second.html").read_text()
    assert "Fields printed otherwise: none." in Path("second.html").read_text()
    assert certify(station, "--amend", "it was broken", "--condition", "cracked", "--out", "third.html")[0] == 0
    assert "Fields printed otherwise: Condition." in Path("third.html").read_text()
    code, out, _ = station("verify", "first.html")
    assert code == 0
    assert re.search(r"replaced since by No\. EX-\d{4}-0003", out)


def test_a_copy_is_the_same_bytes(db: Database, station: Run) -> None:
    assert station("certificate", "S0101", "--copy")[0] == 3
    certify(station, "--out", "a.html")
    assert station("certificate", "S0101", "--copy", "--out", "b.html")[0] == 0
    assert Path("a.html").read_bytes() == Path("b.html").read_bytes()
    assert station("certificate", "S0101")[0] == 2  # nobody certifies


def test_a_calibration_is_found_by_file_hash_and_serial_number(db: Database, tmp_path: Path) -> None:
    with db.write() as session:
        newest = accepted(session)
    with db.read() as session:
        first = find_calibration(session, "S0101")
        assert first.sha256 == newest.sha256
        (tmp_path / "calibration.json").write_text(first.document)
        for name in (newest.sha256, newest.sha256[:8], str(tmp_path / "calibration.json")):
            assert find_calibration(session, name).sha256 == newest.sha256
        for name in ("S9", "", "%", "dead00", newest.sha256[:5]):
            with pytest.raises(NotInDatabase):
                find_calibration(session, name)


@pytest.mark.parametrize(
    "at", ["station.results.certificate.issuing.record_issue", "station.files.atomic_file.os.replace"]
)
def test_a_kill_leaves_nothing_false(
    db: Database, station: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at: str
) -> None:
    def run_and_die(_: Database) -> None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")
        monkeypatch.setattr(at, die)
        certify(station, "--out", "a.html")

    killed(tmp_path / "station.db", run_and_die)
    assert not Path("a.html").exists()
    assert station("verify")[0] == 0
    if at.endswith("record_issue"):
        assert station("certificate", "S0101", "--copy", "--out", "a.html")[0] == 3
        assert "0001" in certify(station, "--out", "a.html")[1]
    else:
        assert station("certificate", "S0101", "--copy", "--out", "a.html")[0] == 0
    assert station("verify", "a.html")[0] == 0


def test_a_printed_head_shows_that_its_row_was_dropped(db: Database, station: Run) -> None:
    with db.write() as session:
        fill_fixtures(session)
    certify(station, "--out", "first.html")
    certify(station, "--amend", "a misprint", "--out", "a.html")
    records = re.findall(
        r"<th>([^<]+)</th><td[^>]*><span class=\"hash\">([0-9a-f]{64})", Path("a.html").read_text()
    )
    heads = dict(records)
    tables = {
        "Newest calibration": "calibrations", "Newest face certificate": "face_certificates",
        "Newest surface plate level": "slab_levels", "Certificate before this": "certificates",
    }  # fmt: skip
    assert set(heads) == {*tables, "This calibration"}
    [heads["Journal of the database"]] = re.findall(r"\d+-[0-9a-f]{16}", Path("a.html").read_text())
    for name in heads:
        assert station("verify", "--head", heads[name])[0] == 0, name
    with db.write() as session:
        for table in (*tables.values(), "cube_measurements", "journal"):
            unprotect(session, table)
            session.execute(text(f"DELETE FROM {table}"))
        for owner in ("cubes", "slabs"):
            session.execute(text(f"UPDATE {owner} SET certificate_date = NULL, due_date = NULL"))
    for name in heads:
        assert station("verify", "--head", heads[name])[0] == 1, name


def test_without_the_extra_the_html_is_written_and_pdf_refused(
    db: Database, station: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    code, _, error = certify(station, "--out", "a.html", "--pdf")
    assert code == 2
    assert "make extra-pdf" in error
    assert station("verify", "a.html")[0] == 0
    assert not Path("a.pdf").exists()


@pytest.mark.parametrize("day", ["2026-03-05", "2999-01-01"])
def test_a_unit_received_too_late_is_refused(db: Database, station: Run, day: str) -> None:
    code, _, error = certify(station, "--received", day, "--out", "a.html")
    assert (code, f"--received: found {day}, expected no day after" in error) == (3, True)
    assert not Path("a.html").exists()


@pytest.mark.parametrize(
    ("table", "change"), [("certificates", "html = 'x'"), ("calibrations", "document = '{}'")]
)
def test_a_file_is_not_as_stored_where_its_row_is_broken(
    db: Database, station: Run, table: str, change: str
) -> None:
    certify(station, "--out", "a.html")
    assert station("verify", "a.html")[0] == 0
    with db.write() as session:
        unprotect(session, table)
        session.execute(text(f"UPDATE {table} SET {change}"))
    code, out, _ = station("verify", "a.html")
    assert (code, "as stored" in out) == (1, False)
