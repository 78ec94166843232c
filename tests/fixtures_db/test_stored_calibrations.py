import json
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from fixtures_db.append_only_rows import newest_hash
from fixtures_db.campaigns import accept_step, campaign, start_campaign
from fixtures_db.database import Database, open_db
from fixtures_db.errors import AlreadyStored, LimitsChanged, NotInDatabase
from fixtures_db.hash_chain import GENESIS, digest
from fixtures_db.imu_models import Limit, set_limits
from fixtures_db.schema import CalibrationRow
from fixtures_db.stored_calibrations import (
    accept_calibration,
    calibrated_models,
    calibration,
    calibration_before,
    calibrations_like,
    history,
    last_calibration,
    newest_calibration,
    stored_runs,
    turn_ons,
    verify_chain,
)
from tests.fixtures_db.edited import edited
from tests.fixtures_db.factory import NOON, facts, fill_fixtures, solution


@pytest.fixture
def filled(db: Database) -> Database:
    for serial in ("S1", "S2", "S1"):
        with db.write() as session:
            accept_calibration(session, solution(), facts(serial))
    return db


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
        with pytest.raises(NotInDatabase, match="0000"):
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


def test_a_calibration_says_what_it_rests_on(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        documents = [json.loads(row.document) for row in calibrations_like(session, "")]
        steps = campaign(session, "b").manifest_sha256
    assert [one.get("manifest") for one in documents[2:6]] == [None, steps, steps, None]
    assert [one["used"].keys() >= {"campaign"} for one in documents[2:6]] == [False, True, True, False]
    assert all(one["used"].keys() >= {"imu", "limits"} for one in documents)


def test_the_same_numbers_from_the_same_files_are_stored_once_from_a_campaign(of_campaigns: Database) -> None:
    with of_campaigns.read() as session:
        stored = session.get_one(CalibrationRow, 4).sha256
    with pytest.raises(AlreadyStored) as caught, of_campaigns.write() as session:
        accept_calibration(session, solution(), facts(), campaign_folder="b")
    assert caught.value.sha256 == stored


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
    reported = replace(facts(), verdict=verdict, limits=limits)
    try:
        with sqlite_db.write() as session:
            accept_calibration(session, solution(), reported)
    except LimitsChanged:
        assert not is_stored
    with sqlite_db.read() as session:
        assert len(history(session, "S1")) == is_stored


ALTERED = "ab" * 32


def test_steps_accepted_after_a_calibration_leave_it_as_it_is_and_altered_ones_do_not(
    rolled_back: Database,
) -> None:
    with edited(rolled_back) as session:
        accept_step(session, "c1", name="late", file="late.csv", sha256=ALTERED, accepted_utc=NOON)
        assert verify_chain(session) == []
    with edited(rolled_back, f"UPDATE steps SET sha256 = '{ALTERED}' WHERE id = 3") as session:
        [fault] = verify_chain(session)
        assert (fault.row, fault.found) == ("calibration 1", "campaign c1 as it is")


ENDED = datetime(2026, 3, 1, 9, tzinfo=UTC)


def test_a_document_says_more_than_its_campaign(db: Database) -> None:
    with db.write() as session:
        fill_fixtures(session)
        start_campaign(
            session, "c1", model="FOG-3", serial="S1", started_utc=NOON, cube_id="CUBE-7", site_id="SITE-1"
        )
        accept_calibration(session, solution(), facts(), campaign_folder="c1")
        reported = replace(
            facts("S2"),
            operator="A. Miller",
            procedure={"name": "twelve positions", "ended_utc": "2026-03-01T10:00:00+01:00"},
            references=({"kind": "cube", "id": "CUBE-9"}, {"kind": "slab", "id": "SLAB-1"}),
        )
        accept_calibration(session, solution(), reported)
    with db.read() as session:
        old, new = stored_runs(session, model="FOG-3")
        assert [one.sha256 for one in stored_runs(session, serial="S2")] == [new.sha256]
        assert stored_runs(session, model="FOG-4") == []
        assert calibrated_models(session) == ["FOG-3"]
    assert old.made_with == {"cube": "CUBE-7", "site": "SITE-1"}
    assert new.made_with == {"cube": "CUBE-9", "slab": "SLAB-1", "operator": "A. Miller"}
    assert (old.ended, new.ended) == (NOON, ENDED)


def test_a_campaign_solved_twice_is_one_turn_on_and_they_stand_by_time(db: Database) -> None:
    with db.write() as session:
        start_campaign(session, "c1", model="FOG-3", serial="S1", started_utc=NOON)
        accept_calibration(session, solution(1e-3), facts(), campaign_folder="c1")
        early = replace(facts(), inputs={"a.csv": "cd" * 32}, procedure={"ended_utc": "2026-03-01T09:00:00Z"})
        accept_calibration(session, solution(2e-3), early)
        accept_calibration(session, solution(3e-3), facts(), campaign_folder="c1")
    with db.read() as session:
        runs = stored_runs(session, serial="S1")
    assert [run.document["accelerometer"]["bias"]["value"][0] for run in runs] == [1e-3, 2e-3, 3e-3]
    assert [run.document["accelerometer"]["bias"]["value"][0] for run in turn_ons(runs)] == [2e-3, 3e-3]
