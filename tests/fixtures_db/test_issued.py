from datetime import timedelta

import pytest
from sqlalchemy import text
from sqlalchemy.exc import DBAPIError

from fixtures_db.database import Database
from fixtures_db.errors import NotInDatabase
from fixtures_db.hash_chain import GENESIS, ChainFault, digest
from fixtures_db.issued import issued_as, issued_of, next_number, record_issue, verify_issued
from fixtures_db.schema import IssuedCertificateRow
from fixtures_db.stored_calibrations import accept_calibration
from tests.fixtures_db.edited import edited
from tests.fixtures_db.factory import NOON, facts, solution, unprotect


@pytest.fixture
def calibrated(db: Database) -> str:
    """The hash of a calibration of which three certificates were issued."""
    with db.write() as session:
        sha256 = accept_calibration(session, solution(), facts()).sha256
    replaces = None
    for day in range(3):
        with db.write() as session:
            number = next_number(session, "EX-", 2026)
            row = IssuedCertificateRow(
                number=number, replaces=replaces, calibration_sha256=sha256, laboratory="L",
                issued_utc=NOON + timedelta(days=day), html=f"<p>\u00b5g {day}</p>",
            )  # fmt: skip
            record_issue(session, row)
            replaces = number
    return sha256


def test_certificates_are_numbered_and_the_last_is_in_force(db: Database, calibrated: str) -> None:
    with db.read() as session:
        rows = issued_of(session, calibrated)
        assert [(row.number, row.replaces) for row in rows] == [
            ("EX-2026-0001", None), ("EX-2026-0002", "EX-2026-0001"), ("EX-2026-0003", "EX-2026-0002"),
        ]  # fmt: skip
        assert verify_issued(session) == []
        assert verify_issued(session, rows[-1].sha256) == []
        assert issued_as(session, rows[1].html_sha256).number == "EX-2026-0002"
        with pytest.raises(NotInDatabase):
            issued_as(session, "0" * 64)


@pytest.mark.parametrize("statement", ["UPDATE certificates SET html = 'x'", "DELETE FROM certificates"])
def test_the_database_refuses_to_change_a_certificate(db: Database, calibrated: str, statement: str) -> None:
    with pytest.raises(DBAPIError, match="append-only"), db.write() as session:
        session.execute(text(statement))


@pytest.mark.parametrize(
    ("statement", "row"),
    [
        ("UPDATE certificates SET html = '<p>' WHERE id = 2", 2),
        ("UPDATE certificates SET replaces = NULL WHERE id = 3", 3),
        ("UPDATE certificates SET issued_utc = '2026-03-04 12:00:01.000000' WHERE id = 1", 1),
        ("DELETE FROM certificates WHERE id = 2", 3),
        ("UPDATE certificates SET id = 9 WHERE id = 1", 2),
    ],
)
def test_tampering_is_found_at_its_row(db: Database, calibrated: str, statement: str, row: int) -> None:
    with db.write() as session:
        unprotect(session, "certificates")
        session.execute(text(statement))
    with db.read() as session:
        assert verify_issued(session)[0].row == f"issued certificate {row}"


def test_a_certificate_of_no_calibration_is_found(db: Database, calibrated: str) -> None:
    with db.write() as session:
        unprotect(session, "calibrations")
        session.execute(text("DELETE FROM calibrations"))
    with db.read() as session:
        assert verify_issued(session)[0].found == "no such calibration"


HTML = [f"<html>EX-2026-000{number}</html>" for number in (1, 2)]
DCC = [f"<dcc>EX-2026-000{number}</dcc>" for number in (1, 2)]


@pytest.mark.parametrize(
    ("statement", "number"),
    [
        ("DELETE FROM certificates", "LAB/2031-0001"),
        ("DELETE FROM certificates WHERE id = 2", "LAB/2031-0002"),
        ("SELECT 1", "LAB/2031-0003"),
    ],
)
def test_the_next_number_counts_every_certificate_there_is(
    rolled_back: Database, statement: str, number: str
) -> None:
    with edited(rolled_back, statement) as session:
        assert next_number(session, "LAB/", 2031) == number


def test_a_certificate_has_the_hashes_of_its_texts_and_of_the_one_before(rolled_back: Database) -> None:
    with rolled_back.read() as session:
        rows = session.query(IssuedCertificateRow).order_by(IssuedCertificateRow.id).all()
        assert [row.html_sha256 for row in rows] == list(map(digest, HTML))
        assert [row.dcc_sha256 for row in rows] == list(map(digest, DCC))
        assert [row.previous for row in rows] == [GENESIS, rows[0].sha256]
        for row, html, dcc in zip(rows, HTML, DCC, strict=True):
            assert issued_as(session, digest(html)) is row
            assert issued_as(session, digest(dcc)) is row
        assert issued_of(session, GENESIS) == []
        kept = "ab" * 32
        assert verify_issued(session, kept) == [ChainFault("newest issued certificate", rows[1].sha256, kept)]


def test_a_certificate_without_xml_has_no_hash_of_it(db: Database, calibrated: str) -> None:
    with db.read() as session:
        assert [row.dcc_sha256 for row in issued_of(session, calibrated)] == [None] * 3


@pytest.mark.parametrize(
    ("change", "found", "expected"),
    [
        ("html = '<p>'", f"html with sha256 {digest('<p>')}", digest(HTML[1])),
        ("dcc = '<p/>'", f"XML with sha256 {digest('<p/>')}", digest(DCC[1])),
        ("dcc = NULL", "XML with sha256 None", digest(DCC[1])),
        ("dcc_sha256 = NULL", f"XML with sha256 {digest(DCC[1])}", "None"),
        (f"calibration_sha256 = '{GENESIS}'", "no such calibration", GENESIS),
    ],
)
def test_what_a_certificate_was_altered_in_is_said_beside_its_hash(
    rolled_back: Database, change: str, found: str, expected: str
) -> None:
    with edited(rolled_back, f"UPDATE certificates SET {change} WHERE id = 2") as session:
        by_chain, *others = verify_issued(session)
        assert by_chain.found.startswith("text with sha256 ")
        assert others == [ChainFault("issued certificate 2", found, expected)]
