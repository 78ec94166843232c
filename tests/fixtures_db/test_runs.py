"""Stored calibrations come with what they were made with, said by the document or else by the campaign."""

from dataclasses import replace
from datetime import UTC, datetime

from fixtures_db.campaigns import start_campaign
from fixtures_db.database import Database
from fixtures_db.stored_calibrations import accept_calibration, calibrated_models, stored_runs, turn_ons
from tests.fixtures_db.factory import NOON, facts, fill_fixtures, solution

ENDED = datetime(2026, 3, 1, 9, tzinfo=UTC)


def test_a_document_says_more_than_its_campaign(db: Database) -> None:
    with db.write() as session:
        fill_fixtures(session)
        start_campaign(
            session, "c1", model="FOG-3", serial="S1", started_utc=NOON, cube_id="CUBE-7", site_id="SITE-1"
        )
        accept_calibration(session, solution(), facts(), campaign_folder="c1")
        said = replace(
            facts("S2"),
            operator="A. Miller",
            procedure={"name": "twelve positions", "ended_utc": "2026-03-01T10:00:00+01:00"},
            references=({"kind": "cube", "id": "CUBE-9"}, {"kind": "slab", "id": "SLAB-1"}),
        )
        accept_calibration(session, solution(), said)
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
