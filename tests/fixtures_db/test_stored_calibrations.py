import json

import numpy as np
import pytest
from sqlalchemy import text
from sqlalchemy.exc import DBAPIError

from fixtures_db.append_only_rows import newest_hash
from fixtures_db.database import Database
from fixtures_db.hash_chain import GENESIS, digest
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import accept_calibration, history, verify_chain
from tests.fixtures_db.factory import facts, solution, unprotect


@pytest.fixture
def filled(db: Database) -> Database:
    for serial in ("S1", "S2", "S1"):
        with db.write() as session:
            accept_calibration(session, solution(), facts(serial))
    return db


def _tamper(db: Database, statement: str) -> None:
    with db.write() as session:
        unprotect(session, "calibrations")
        session.execute(text(statement))


def test_history_holds_the_calibrations_of_a_unit_in_order(filled: Database) -> None:
    with filled.read() as session:
        rows = history(session, "S1")
        assert [row.id for row in rows] == [1, 3]
        assert history(session, "S9") == []
        assert rows[0].previous == GENESIS
        assert newest_hash(session, CalibrationRow) == rows[-1].sha256


def test_the_stored_text_is_calibration_1_and_its_hash(filled: Database) -> None:
    with filled.read() as session:
        row = history(session, "S1")[0]
    document = json.loads(row.document)
    assert digest(row.document) == row.sha256
    assert document["format"] == "calibration/1"
    assert document["effects"] == []
    assert document["previous"] == GENESIS
    assert document["inputs"] == {"dwell_01.csv": "ab" * 32}
    assert "gyroscope" not in document
    np.testing.assert_array_equal(document["accelerometer"]["bias"]["value"], solution().accelerometer.bias.value)
    assert row.accepted_utc == facts().accepted_utc


CHANGES = {
    "sqlite": "INSERT OR REPLACE INTO calibrations SELECT * FROM calibrations WHERE id = 2",
    "postgresql": "TRUNCATE calibrations",
    "both": "UPDATE calibrations SET document = 'x'; DELETE FROM calibrations; INSERT INTO calibrations "
    "SELECT * FROM calibrations WHERE id = 2 ON CONFLICT (id) DO UPDATE SET document = 'x'",
}


def test_the_database_refuses_to_change_a_calibration(filled: Database) -> None:
    for statement in [CHANGES[filled.engine.dialect.name], *CHANGES["both"].split("; ")]:
        with pytest.raises(DBAPIError, match="append-only"), filled.write() as session:
            session.execute(text(statement))
    with filled.read() as session:
        assert verify_chain(session) == []


@pytest.mark.parametrize(
    ("statement", "row"),
    [
        ("UPDATE calibrations SET document = replace(document, '1020.0', '1021.0') WHERE id = 2", "calibration 2"),
        ("UPDATE calibrations SET inputs = '{}' WHERE id = 1", "calibration 1"),
        ("UPDATE calibrations SET accepted_utc = '2026-03-04 12:00:01.000000' WHERE id = 1", "calibration 1"),
        ("UPDATE calibrations SET imu_id = 2 WHERE id = 1", "calibration 1"),
        ("UPDATE calibrations SET document = 'not json' WHERE id = 3", "calibration 3"),
        ("DELETE FROM calibrations WHERE id = 2", "calibration 3"),
        ("DELETE FROM calibrations WHERE id = 1", "calibration 2"),
        ("UPDATE calibrations SET id = 9 WHERE id = 1", "calibration 2"),
    ],
)
def test_tampering_is_found_at_its_row(filled: Database, statement: str, row: str) -> None:
    _tamper(filled, statement)
    with filled.read() as session:
        assert verify_chain(session)[0].row == row


def test_a_dropped_newest_row_is_found_against_a_kept_head(filled: Database) -> None:
    with filled.read() as session:
        kept = newest_hash(session, CalibrationRow)
        assert verify_chain(session, kept) == []
    _tamper(filled, "DELETE FROM calibrations WHERE id = 3")
    with filled.read() as session:
        assert verify_chain(session) == []
        assert verify_chain(session, kept)[0].expected == kept


def test_nan_never_enters_a_calibration(filled: Database) -> None:
    with pytest.raises(ValueError, match="JSON"), filled.write() as session:
        accept_calibration(session, solution(float("nan")), facts())
