import pytest

from fixtures_db.database import Database
from fixtures_db.hash_chain import GENESIS, ChainFault, digest
from fixtures_db.issued_certificates import issued_as, issued_of, next_number, signed_as, verify_issued
from fixtures_db.schema import IssuedCertificateRow
from tests.fixtures_db.edited import edited

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


def test_a_file_is_found_by_its_own_hash(filled: Database) -> None:
    with filled.read() as session:
        for letter, kind in (("p", "pdf"), ("x", "xml")):
            found = signed_as(session, letter.encode().hex() * 32)
            assert found is not None
            assert (found.kind, found.number) == (kind, "EX-2026-0001")
        assert signed_as(session, "ab" * 32) is None
