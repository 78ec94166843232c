import pytest
from sqlalchemy import text
from sqlalchemy.exc import DBAPIError

from fixtures_db.anchor import take_anchor
from fixtures_db.database import Database
from fixtures_db.errors import InForceAlready, NotInForce
from fixtures_db.hash_chain_verification import alterations
from fixtures_db.own_effects import add_effect, all_in_force, effects_in_force, verify_effects, withdraw_effect
from tests.fixtures_db.factory import protect_again, unprotect

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
        pytest.raises(InForceAlready, match="of FOG-3 S1 is in force already with these bytes"),
        stored.write() as session,
    ):
        add_effect(session, NAME, "of the unit", "FOG-3", "S1")
    with (
        pytest.raises(NotInForce, match=r"not in force, expected one that is \(gyroscope\.dead_zone\)"),
        stored.write() as session,
    ):
        withdraw_effect(session, "gyroscope.other", "FOG-3", "S1")


@pytest.mark.parametrize("statement", ["UPDATE effect_events SET serial = NULL", "DELETE FROM effect_events"])
def test_the_database_refuses_to_change_an_event(stored: Database, statement: str) -> None:
    with pytest.raises(DBAPIError, match="append-only"), stored.write() as session:
        session.execute(text(statement))


@pytest.mark.parametrize(
    ("statement", "row"),
    [
        ("UPDATE effect_events SET definition = 'x' WHERE id = 2", 2),
        ("UPDATE effect_events SET model = 'FOG-4' WHERE id = 1", 1),
        ("DELETE FROM effect_events WHERE id = 2", 3),
    ],
)
def test_tampering_is_found_at_its_row(stored: Database, statement: str, row: int) -> None:
    with stored.write() as session:
        unprotect(session, "effect_events")
        session.execute(text(statement))
    with stored.read() as session:
        assert verify_effects(session)[0].row == f"effect {row}"
        assert f"effect {row}" in {fault.row for fault in alterations(session)}


def test_an_event_dropped_at_the_end_shows_against_an_anchor(stored: Database) -> None:
    with stored.read() as session:
        anchor = take_anchor(session)
        assert alterations(session, anchor) == []
    with stored.write() as session:
        unprotect(session, "effect_events")
        session.execute(text("DELETE FROM effect_events WHERE id = 4"))
        protect_again(session, "effect_events")
    with stored.read() as session:
        assert [fault.row for fault in alterations(session)] == ["effect_events 4"]
        assert [fault.row for fault in alterations(session, anchor)] == ["newest effect", "effect_events 4"]
