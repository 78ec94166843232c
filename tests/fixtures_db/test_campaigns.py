from datetime import datetime

import pytest
from sqlalchemy import text

from fixtures_db.campaigns import accept_step, campaign, manifest_head, set_state, start_campaign, verify_steps
from fixtures_db.database import Database
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.hash_chain import GENESIS
from tests.fixtures_db.factory import NOON


def test_accepted_steps_extend_the_manifest_and_supersede_by_name(db: Database) -> None:
    with db.write() as session:
        row = start_campaign(session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON, cube_id="P1")
        heads = [row.manifest_sha256]
        for number, name in enumerate(("dwell_01", "dwell_02", "dwell_01")):
            file, sha256 = f"{name}_{number}.mcap", f"{number:064x}"
            accept_step(session, "/data/1", name=name, file=file, sha256=sha256, accepted_utc=NOON)
            heads.append(row.manifest_sha256)
        set_state(session, "/data/1", "recorded")
    assert heads[0] == GENESIS
    assert len(set(heads)) == 4
    with db.read() as session:
        stored = campaign(session, "/data/1")
        assert stored.state == "recorded"
        assert [step.superseded for step in stored.steps] == [True, False, False]
        assert manifest_head(stored.steps) == stored.manifest_sha256
        assert stored.imu.serial == "S1"


def test_wrong_names_and_times_are_refused(db: Database) -> None:
    with db.write() as session:
        start_campaign(session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON)
        with pytest.raises(AlreadyThere):
            start_campaign(session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON)
        with pytest.raises(NotInDatabase, match="/data/1"):
            campaign(session, "/data/2")
        with pytest.raises(ValueError, match="recording"):
            set_state(session, "/data/1", "lost")
    with pytest.raises(Exception, match="no time zone"), db.write() as session:
        start_campaign(session, "/data/2", model="FOG-3", serial="S1", started_utc=datetime(2026, 1, 1))
    with pytest.raises(Exception, match=r"(?i)foreign ?key"), db.write() as session:
        start_campaign(session, "/data/3", model="FOG-3", serial="S1", started_utc=NOON, cube_id="no such cube")


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE steps SET sha256 = replace(sha256, '1', '2') WHERE id = 2",
        "UPDATE steps SET superseded = true WHERE id = 2",
        "DELETE FROM steps WHERE id = 3",
        "UPDATE campaigns SET manifest_sha256 = replace(manifest_sha256, 'a', 'b')",
    ],
)
def test_an_altered_step_is_found_at_its_campaign(db: Database, statement: str) -> None:
    with db.write() as session:
        start_campaign(session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON)
        for number, name in enumerate(("dwell_01", "dwell_02", "dwell_01")):
            accept_step(
                session, "/data/1", name=name, file=f"{number}", sha256=f"{number:064x}", accepted_utc=NOON
            )
    with db.write() as session:
        assert verify_steps(session) == []
        session.execute(text(statement))
    with db.read() as session:
        assert "/data/1" in verify_steps(session)[0].row
        assert verify_steps(session, "/data/2") == []


def test_steps_are_read_in_the_order_in_which_they_were_accepted(sqlite_db: Database) -> None:
    """SQLite gives rows of which no order is asked the other way round here, as another database may."""
    with sqlite_db.write() as session:
        start_campaign(session, "/data/1", model="FOG-3", serial="S1", started_utc=NOON)
        for number in range(3):
            accept_step(
                session, "/data/1", name=f"d{number}", file=f"{number}", sha256=f"{number:064x}", accepted_utc=NOON
            )
    with sqlite_db.read() as session:
        session.execute(text("PRAGMA reverse_unordered_selects = ON"))
        assert [step.name for step in campaign(session, "/data/1").steps] == ["d0", "d1", "d2"]
        assert verify_steps(session) == []
