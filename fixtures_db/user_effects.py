"""User-defined error terms of an IMU model or one unit of it: events in a chain, only ever added.

An effect is in force from its ``add`` to its ``withdraw``; what a unit has stands before what its model has.
"""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, newest_hash, row_text, verify_rows
from fixtures_db.errors import InForceAlready, NotInForce
from fixtures_db.hash_chain import ChainFault, digest
from fixtures_db.schema import EffectEventRow

ADD, WITHDRAW = "add", "withdraw"


def add_effect(session: Session, name: str, definition: str, model: str, serial: str | None) -> EffectEventRow:
    """Put an effect/1 in force for a model or, with ``serial``, one unit; it takes the place of one of its name.

    Call it in `fixtures_db.database.Database.write`.

    Raises
    ------
    InForceAlready
        If the same text is in force there.
    """
    now, sha256 = _newest(session, model, serial).get(name), digest(definition)
    if now is not None and (now.event, now.effect_sha256) == (ADD, sha256):
        raise InForceAlready(owner(model, serial), name)
    return _append(session, EffectEventRow(event=ADD, name=name, model=model, serial=serial,
                                           effect_sha256=sha256, definition=definition))  # fmt: skip


def withdraw_effect(session: Session, name: str, model: str, serial: str | None) -> EffectEventRow:
    """Take an effect out of force; its row stays. Call it in `fixtures_db.database.Database.write`.

    Raises
    ------
    NotInForce
        If there is none in force there.
    """
    known = _newest(session, model, serial)
    now = known.get(name)
    if now is None or now.event != ADD:
        there = [each.name for each in known.values() if each.event == ADD]
        raise NotInForce(owner(model, serial), name, there)
    return _append(session, EffectEventRow(event=WITHDRAW, name=name, model=model, serial=serial,
                                           effect_sha256=now.effect_sha256, definition=""))  # fmt: skip


def effects_in_force(session: Session, model: str, serial: str | None) -> tuple[EffectEventRow, ...]:
    """Return the effects of a unit, its model's among them, by name; without ``serial`` of the model alone."""
    found = {name: row for name, row in _newest(session, model, None).items() if row.event == ADD}
    if serial is not None:
        found |= {name: row for name, row in _newest(session, model, serial).items() if row.event == ADD}
    return tuple(found[name] for name in sorted(found))


def all_in_force(session: Session) -> tuple[EffectEventRow, ...]:
    """Return every effect in force, by model, unit and name."""
    owners = {(row.model, row.serial) for row in session.scalars(select(EffectEventRow))}
    rows = (row for model, serial in owners for row in _newest(session, model, serial).values())
    kept = (row for row in rows if row.event == ADD)
    return tuple(sorted(kept, key=lambda row: (row.model, row.serial or "", row.name)))


def owner(model: str, serial: str | None) -> str:
    """Return whose an effect is in words."""
    return f"model {model}" if serial is None else f"{model} {serial}"


def _newest(session: Session, model: str, serial: str | None) -> dict[str, EffectEventRow]:
    """Return the last event of each name of a model or a unit."""
    of_owner = select(EffectEventRow).where(EffectEventRow.model == model, EffectEventRow.serial.is_(serial)
                                            if serial is None else EffectEventRow.serial == serial)  # fmt: skip
    rows: Sequence[EffectEventRow] = session.scalars(of_owner.order_by(EffectEventRow.id)).all()
    return {row.name: row for row in rows}


def _append(session: Session, row: EffectEventRow) -> EffectEventRow:
    row.recorded_utc, row.previous = datetime.now(UTC), newest_hash(session, EffectEventRow)
    row.sha256 = digest(row_text(row))
    session.add(row)
    session.flush()
    return row


def verify_effects(session: Session, expected_head: str | None = None) -> list[ChainFault]:
    """Return every event that was altered, dropped or reordered since, or whose effect has another hash.

    Rows dropped at the newest end show only against ``expected_head``, a hash that was kept elsewhere.
    """

    def others(row: EffectEventRow) -> Iterator[ChainFault]:
        if row.event == ADD and (actual := digest(row.definition)) != row.effect_sha256:
            yield ChainFault(f"{ROW_TITLES[EffectEventRow]} {row.id}", f"sha256 {actual}", row.effect_sha256)

    return verify_rows(session, EffectEventRow, expected_head, others)
