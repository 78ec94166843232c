import json
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from sqlalchemy import text
from sqlalchemy.exc import DBAPIError

from fixtures_db.append_only_rows import newest_hash
from fixtures_db.campaigns import accept_step, campaign, start_campaign
from fixtures_db.database import Database, open_db
from fixtures_db.errors import AlreadyStored, LimitsChanged, NotInDatabase
from fixtures_db.hash_chain import GENESIS, ChainFault, digest
from fixtures_db.journal import journal_head
from fixtures_db.model_limits import Limit, set_limits
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import (
    accept_calibration,
    calibrated_serials,
    calibration,
    calibration_before,
    calibrations_like,
    history,
    last_calibration,
    newest_calibration,
    verify_chain,
)
from tests.fixtures_db.edited import edited
from tests.fixtures_db.factory import NOON, facts, solution, unprotect


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


OTHER_MODEL = replace(facts("S1"), model="FOG-5")


@pytest.fixture(scope="module")
def of_campaigns(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Database]:
    """Calibrations 1 to 7: S2, S1 of "a", S1 of another model, S1 of "b" twice, S1 of none, S1 of "a" again."""
    with open_db(tmp_path_factory.mktemp("calibrations") / "station.db") as db:
        with db.write() as session:
            for folder in "ab":
                start_campaign(session, folder, model="FOG-3", serial="S1", started_utc=NOON)
                accept_step(session, folder, name="d", file="d.csv", sha256="cd" * 32, accepted_utc=NOON)
            accept_calibration(session, solution(), facts("S2"))
            accept_calibration(session, solution(), facts(), campaign_folder="a")
            accept_calibration(session, solution(), OTHER_MODEL)
            for bias in (1e-3, 2e-3):
                accept_calibration(session, solution(bias), facts(), campaign_folder="b")
            accept_calibration(session, solution(), facts())
            accept_calibration(session, solution(3e-3), facts(), campaign_folder="a")
        yield db


def test_a_calibration_is_found_by_its_hash_and_by_how_it_begins(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        rows = calibrations_like(session, "")
        assert [row.id for row in rows] == [1, 2, 3, 4, 5, 6, 7]
        for row in rows:
            assert calibration(session, row.sha256) is row
            assert list(calibrations_like(session, row.sha256[:20])) == [row]
        for not_a_hash in ("%", "_", rows[0].sha256[1:]):
            assert calibrations_like(session, not_a_hash) == []
        with pytest.raises(NotInDatabase, match="no calibration '0000"):
            calibration(session, GENESIS)


@pytest.mark.parametrize(("row", "before"), [(1, None), (2, None), (3, None), (4, 2), (5, 2), (6, 5), (7, 6)])
def test_a_calibration_took_the_place_of_the_units_last_that_is_of_another_campaign(
    of_campaigns: Database, row: int, before: int | None
) -> None:
    with of_campaigns.read() as session:
        found = calibration_before(session, session.get_one(CalibrationRow, row))
        assert (found and found.id) == before


@pytest.mark.parametrize(
    ("model", "serial", "but_of", "last"),
    [
        ("FOG-3", "S1", None, 7),
        ("FOG-3", "S1", "a", 6),
        ("FOG-3", "S1", "b", 7),
        ("FOG-3", "S1", "never recorded", 7),
        ("FOG-3", "S2", "a", 1),
        ("FOG-5", "S1", None, 3),
        ("FOG-5", "S2", None, None),
    ],
)
def test_the_last_calibration_is_the_units_newest_that_is_not_of_the_campaign_left_out(
    of_campaigns: Database, model: str, serial: str, but_of: str | None, last: int | None
) -> None:
    with of_campaigns.read() as session:
        found = last_calibration(session, model, serial, but_of)
        assert (found and found.id) == last


@pytest.mark.parametrize(("folder", "newest"), [("a", 7), ("b", 5), ("c", None)])
def test_the_newest_calibration_of_a_campaign_is_the_last_stored_from_it(
    of_campaigns: Database, folder: str, newest: int | None
) -> None:
    with of_campaigns.read() as session:
        found = newest_calibration(session, folder)
        assert (found and found.id) == newest


def test_calibrated_serial_numbers_stand_once_each_in_order(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        assert calibrated_serials(session) == ["S1", "S2"]
        assert [row.id for row in history(session, "S1")] == [2, 3, 4, 5, 6, 7]  # of every model


def test_a_calibration_says_what_it_rests_on(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        documents = [json.loads(row.document) for row in calibrations_like(session, "")]
        steps = campaign(session, "b").manifest_sha256
    assert [one.get("manifest") for one in documents[2:6]] == [None, steps, steps, None]
    assert [one["used"].keys() >= {"campaign"} for one in documents[2:6]] == [False, True, True, False]
    assert all(one["used"].keys() >= {"imu", "limits"} for one in documents)


def test_the_journal_that_a_calibration_names_has_its_unit_and_not_itself(sqlite_db: Database) -> None:
    with sqlite_db.write() as session:
        row = accept_calibration(session, solution(), facts("new"))
        assert journal_head(session).entries == json.loads(row.document)["journal"]["entries"] + 1
    with sqlite_db.read() as session:
        last = session.execute(text("SELECT table_name FROM journal ORDER BY id DESC LIMIT 2")).scalars().all()
        assert last == ["calibrations", "imus"]


def test_the_same_numbers_from_the_same_files_are_stored_once_from_a_campaign(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        stored = session.get_one(CalibrationRow, 4).sha256
    with pytest.raises(AlreadyStored) as caught, of_campaigns.write() as session:
        accept_calibration(session, solution(), facts(), campaign_folder="b")
    assert caught.value.sha256 == stored


@pytest.mark.parametrize(
    ("bias", "inputs"), [(1.5e-3, facts().inputs), (1e-3, {"dwell_01.csv": "ac" * 32}), (2e-3, {})]
)
def test_other_numbers_or_files_of_the_same_campaign_are_another_calibration(
    of_campaigns: Database, bias: float, inputs: dict[str, str]
) -> None:
    with of_campaigns.write() as session:
        row = accept_calibration(session, solution(bias), replace(facts(), inputs=inputs), campaign_folder="b")
        assert (row.id, row.campaign_id, row.previous) == (8, 2, session.get_one(CalibrationRow, 7).sha256)
        session.rollback()


TIGHT, LOOSE = (Limit("accelerometer.bias.x", None, high, "g") for high in (1e-3, 2e-3))


@pytest.mark.parametrize(
    ("verdict", "limits", "is_stored"),
    [("PASS", (TIGHT,), True), ("PASS", (LOOSE,), False), ("PASS", (), False), (None, (LOOSE,), True)],
)
def test_a_verdict_is_stored_where_its_limits_are_those_of_the_model(
    sqlite_db: Database, verdict: str | None, limits: tuple[Limit, ...], is_stored: bool
) -> None:
    with sqlite_db.write() as session:
        set_limits(session, "FOG-3", (TIGHT,))
    said = replace(facts(), verdict=verdict, limits=limits)
    try:
        with sqlite_db.write() as session:
            accept_calibration(session, solution(), said)
    except LimitsChanged:
        assert not is_stored
    with sqlite_db.read() as session:
        assert len(history(session, "S1")) == is_stored


ALTERED = "ab" * 32
MANIFEST = "that of manifest "


@pytest.mark.parametrize(
    ("change", "found", "expected"),
    [
        ("imu_id = 99", "serial column None", "'S2'"),
        ("imu_id = 1", "serial column 'S1'", "'S2'"),
        ("imu_id = 4", "model column 'FOG-5'", "'FOG-3'"),
        ("code_version = 'mine'", "software column 'mine'", "'fog-station 0.1.0'"),
        ("inputs = '{}'", "inputs column {}", f"{{'dwell_01.csv': '{ALTERED}'}}"),
        (
            "accepted_utc = '2026-03-04 12:00:00.500000'",
            "accepted_utc column '2026-03-04T12:00:00.500000Z'",
            "'2026-03-04T12:00:00Z'",
        ),
        ("campaign_id = NULL", "no campaign", MANIFEST),
        ("campaign_id = 99", "no campaign", MANIFEST),
        ("campaign_id = 1", "campaign c1 as it is", MANIFEST),
    ],
)
def test_a_column_that_is_not_as_in_the_document_is_said_with_what_the_document_has(
    rolled_back: Database, change: str, found: str, expected: str
) -> None:
    other = "INSERT INTO imus (id, model, serial) VALUES (4, 'FOG-5', 'S2')"
    with edited(rolled_back, other, f"UPDATE calibrations SET {change} WHERE id = 2") as session:
        if expected == MANIFEST:
            expected += campaign(session, "c2").manifest_sha256
        assert verify_chain(session) == [ChainFault("calibration 2", found, expected)]


def test_a_previous_hash_that_is_not_the_documents_is_said_beside_the_chain(rolled_back: Database) -> None:
    with edited(rolled_back, f"UPDATE calibrations SET previous = '{ALTERED}' WHERE id = 1") as session:
        assert verify_chain(session) == [
            ChainFault("calibration 1", f"previous {ALTERED}", GENESIS),
            ChainFault("calibration 1", f"previous column '{ALTERED}'", repr(GENESIS)),
        ]


@pytest.mark.parametrize(
    ("document", "found", "expected"),
    [
        ("{", "a document that is not JSON", "calibration/1"),
        ("[]", "campaign c1", "that of manifest none"),
        ('{"serial": "S1"}', "campaign c1", "that of manifest none"),
    ],
)
def test_a_document_of_another_form_is_said_to_be_that(
    rolled_back: Database, document: str, found: str, expected: str
) -> None:
    with edited(rolled_back) as session:
        change = text("UPDATE calibrations SET document = :document WHERE id = 1")
        session.execute(change, {"document": document})
        faults = [fault for fault in verify_chain(session) if not fault.found.startswith("text with sha256")]
        assert faults == [ChainFault("calibration 1", found, expected)]


@pytest.mark.parametrize(("step", "is_right"), [("11" * 32, True), ("12" * 32, False)])
def test_a_calibration_of_before_manifests_is_of_the_campaign_that_has_one_of_its_files(
    sqlite_filled: Database, step: str, is_right: bool
) -> None:
    with sqlite_filled.write() as session:
        old = replace(facts(), inputs={"notes.csv": ALTERED, "dwell_01.csv": step})
        assert accept_calibration(session, solution(), old).id == 3
    with edited(sqlite_filled, "UPDATE calibrations SET campaign_id = 1 WHERE id = 3") as session:
        fault = ChainFault("calibration 3", "campaign c1", "that of manifest none")
        assert verify_chain(session) == ([] if is_right else [fault])


def test_a_calibration_of_no_campaign_that_names_one_that_is_gone_is_found(sqlite_filled: Database) -> None:
    with sqlite_filled.write() as session:
        accept_calibration(session, solution(), facts())
    with edited(sqlite_filled, "UPDATE calibrations SET campaign_id = 99 WHERE id = 3") as session:
        assert verify_chain(session) == [ChainFault("calibration 3", "no campaign", "that of manifest none")]


def test_steps_accepted_after_a_calibration_leave_it_as_it_is_and_altered_ones_do_not(
    rolled_back: Database,
) -> None:
    with edited(rolled_back) as session:
        accept_step(session, "c1", name="late", file="late.csv", sha256=ALTERED, accepted_utc=NOON)
        assert verify_chain(session) == []
    with edited(rolled_back, f"UPDATE steps SET sha256 = '{ALTERED}' WHERE id = 3") as session:
        [fault] = verify_chain(session)
        assert (fault.row, fault.found) == ("calibration 1", "campaign c1 as it is")
