"""A signed file is found by the hash of its bytes, and no other is."""

from fixtures_db.database import Database
from fixtures_db.signed_files import signed_as


def test_a_file_is_found_by_its_own_hash(filled: Database) -> None:
    with filled.read() as session:
        for letter, kind in (("p", "pdf"), ("x", "xml")):
            found = signed_as(session, letter.encode().hex() * 32)
            assert found is not None
            assert (found.kind, found.number) == (kind, "EX-2026-0001")
        assert signed_as(session, "ab" * 32) is None
