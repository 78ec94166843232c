"""`station certificate --dcc`: the XML next to the HTML, in the PDF, amended, copied, refused."""

import re
import zlib
from pathlib import Path

import pytest
from sqlalchemy import text

from fixtures_db.database import Database
from fixtures_db.issued_certificates import issued_of
from station.results.certificate.dcc.digital_certificate import schema_faults
from station.results.certificate.issuing import find_calibration
from tests.fixtures_db.factory import unprotect
from tests.station.results.certificate.conftest import Run, certify
from tests.station.results.certificate.dcc_numbers import NS, of_type, parsed, results

EMAIL = ("--customer-email", "imu@sky.example")


def test_the_xml_is_written_next_to_the_html_and_recorded(db: Database, station: Run) -> None:
    code, out, _ = certify(station, *EMAIL, "--dcc", "--out", "a.html")
    assert code == 0
    written = Path("a.xml").read_bytes()
    assert schema_faults(written) == []
    assert len(results(parsed(written))) == 24
    with db.read() as session:
        [row] = issued_of(session, find_calibration(session, "S0101").sha256)
    assert row.dcc == written.decode()
    assert f"a.xml: written, sha256 {row.dcc_sha256}" in out
    assert certify(station, *EMAIL, "--amend", "again", "--out", "b.html")[0] == 0
    assert not Path("b.xml").exists()


def test_a_copy_has_the_same_xml_where_one_was_issued(db: Database, station: Run) -> None:
    certify(station, *EMAIL, "--dcc", "--out", "a.html")
    assert station("certificate", "S0101", "--copy", "--dcc", "--out", "b.html")[0] == 0
    assert Path("a.xml").read_bytes() == Path("b.xml").read_bytes()
    assert certify(station, "--amend", "without", "--out", "c.html")[0] == 0
    code, _, error = station("certificate", "S0101", "--copy", "--dcc", "--out", "d.html")
    assert code == 3
    assert "found no XML, expected one; it was issued without" in error
    assert not Path("d.html").exists()


def test_an_amended_one_names_the_one_that_it_replaces(db: Database, station: Run) -> None:
    _, out, _ = certify(station, *EMAIL, "--dcc", "--out", "a.html")
    [sha256] = re.findall(r"a\.xml: written, sha256 ([0-9a-f]{64})", out)
    first = Path("a.xml").read_bytes()
    assert (
        certify(
            station, *EMAIL, "--dcc", "--amend", "it was cracked", "--condition", "cracked", "--out", "b.html"
        )[0]
        == 0
    )
    root = parsed(Path("b.xml").read_bytes())
    previous = root.find(".//dcc:previousReport", NS)
    assert previous.findtext("dcc:value", None, NS) == sha256
    assert re.fullmatch(r"EX-\d{4}-0001", previous.findtext("dcc:referralID", None, NS))
    [statement] = of_type(root, "fog_amendment", "statement")
    reported = " ".join(statement.itertext())
    assert "it was cracked" in reported
    assert "Fields printed otherwise: Condition." in reported
    assert sha256 in reported
    with db.read() as session:
        rows = issued_of(session, find_calibration(session, "S0101").sha256)
    assert [row.dcc.encode() == first for row in rows] == [True, False]


def test_what_the_form_also_asks_for_is_missed_by_name(db: Database, station: Run, tmp_path: Path) -> None:
    code, out, error = certify(station, "--dcc")
    assert code == 3
    assert re.search(r"missing +customer.email", out)
    assert "customer.email" in error
    assert list(tmp_path.glob("*.xml")) == []


@pytest.mark.parametrize(
    "change",
    [
        "html = html || ' '", "number = 'EX-1'", "laboratory = 'other'", "dcc = dcc || ' '", "dcc = NULL",
        "dcc_sha256 = NULL", "dcc = NULL, dcc_sha256 = NULL",
    ],
)  # fmt: skip
def test_an_altered_row_is_found(db: Database, station: Run, change: str) -> None:
    certify(station, *EMAIL, "--dcc")
    assert station("verify")[0] == 0
    with db.write() as session:
        unprotect(session, "certificates")
        session.execute(text(f"UPDATE certificates SET {change}"))
    code, _, error = station("verify")
    assert (code, "issued certificate 1" in error) == (1, True)


def test_the_pdf_holds_the_xml(db: Database, station: Run) -> None:
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError) as error:
        pytest.skip(f"no PDF here: {error}")
    assert certify(station, *EMAIL, "--dcc", "--pdf", "--out", "a.html")[0] == 0
    content = Path("a.pdf").read_bytes()
    streams = list(_streams(content))
    assert Path("a.xml").read_bytes() in streams
    assert any(b'pdfaid:part="3"' in one for one in (*streams, content))
    Path("a.pdf").unlink()
    assert station("certificate", "S0101", "--copy", "--out", "a.html", "--pdf")[0] == 0
    assert Path("a.pdf").read_bytes() == content


def _streams(content: bytes) -> list[bytes]:
    found = []
    for one in re.findall(rb"(?s)stream\n(.*?)\nendstream", content):
        try:
            found.append(zlib.decompress(one))
        except zlib.error:
            found.append(one)
    return found
