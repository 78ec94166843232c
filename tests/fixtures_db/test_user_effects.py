import pytest

from fixtures_db.database import Database
from fixtures_db.errors import InForceAlready, NotInForce
from fixtures_db.imu_models import add_effect, all_in_force, effects_in_force, withdraw_effect
from procedures.errors import ErrorCode
from tests.refusals import refused

NAME = "gyroscope.dead_zone"


@pytest.fixture
def stored(db: Database) -> Database:
    """An effect of a model, one of the same name of a unit of it, one more of the unit, withdrawn."""
    with db.write() as session:
        add_effect(session, NAME, "of the model", "FOG-3", None)
        add_effect(session, NAME, "of the unit", "FOG-3", "S1")
        add_effect(session, "gyroscope.other", "\u00b5g", "FOG-3", "S1")
        withdraw_effect(session, "gyroscope.other", "FOG-3", "S1")
    return db


def test_what_a_unit_has_stands_before_what_its_model_has(stored: Database) -> None:
    with stored.write() as session:
        assert [row.definition for row in effects_in_force(session, "FOG-3", "S1")] == ["of the unit"]
        assert [row.definition for row in effects_in_force(session, "FOG-3", "S2")] == ["of the model"]
        assert [row.definition for row in effects_in_force(session, "FOG-3", None)] == ["of the model"]
        assert effects_in_force(session, "FOG-4", "S1") == ()
        assert [(row.serial, row.name) for row in all_in_force(session)] == [(None, NAME), ("S1", NAME)]
        withdraw_effect(session, NAME, "FOG-3", "S1")
        assert [row.definition for row in effects_in_force(session, "FOG-3", "S1")] == ["of the model"]
        add_effect(session, NAME, "of the unit", "FOG-3", "S1")
        assert [row.definition for row in effects_in_force(session, "FOG-3", "S1")] == ["of the unit"]


def test_what_changes_nothing_is_refused(stored: Database) -> None:
    with (
        refused(InForceAlready, ErrorCode.DATABASE, "FOG-3 S1"),
        stored.write() as session,
    ):
        add_effect(session, NAME, "of the unit", "FOG-3", "S1")
    with (
        refused(NotInForce, ErrorCode.DATABASE, NAME),
        stored.write() as session,
    ):
        withdraw_effect(session, "gyroscope.other", "FOG-3", "S1")
