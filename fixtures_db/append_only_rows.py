"""Measured rows that are only ever added: face certificates, cubes by IMUs, slab levels; each a hash chain.

Triggers refuse to change or delete rows of a chained table; `trigger_faults` checks that all are as they were
made.
"""

from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, date, datetime
from itertools import chain
from typing import Any, TypeVar

from sqlalchemy import Connection, select, text
from sqlalchemy.orm import Session

from fixtures_db.fixtures import KIND_NAMES, fixture_rows
from fixtures_db.hash_chain import GENESIS, ChainFault, Link, canonical, digest, faults
from fixtures_db.schema import (
    Base,
    CalibrationRow,
    CubeMeasurementRow,
    CubeRow,
    EffectEventRow,
    FaceCertificateRow,
    IssuedCertificateRow,
    SignedFileRow,
    SlabLevelRow,
    SlabRow,
)

Measured = TypeVar("Measured", FaceCertificateRow, CubeMeasurementRow, SlabLevelRow)
Chained = TypeVar(
    "Chained",
    CalibrationRow,
    IssuedCertificateRow,
    SignedFileRow,
    FaceCertificateRow,
    CubeMeasurementRow,
    SlabLevelRow,
    EffectEventRow,
)  # fmt: skip
ROW_TITLES: dict[type[Any], str] = {
    CalibrationRow: "calibration", IssuedCertificateRow: "issued certificate", SignedFileRow: "signed file",
    FaceCertificateRow: "face certificate", CubeMeasurementRow: "cube measurement", SlabLevelRow: "slab level",
    EffectEventRow: "effect",
}  # fmt: skip
NOT_HASHED = frozenset({"id", "sha256"})
HASHED_WHERE_GIVEN = frozenset({"dcc", "dcc_sha256"})  # columns younger than rows that were hashed without them


def append(session: Session, row: Measured) -> Measured:
    """Chain a row to the newest of its table and add it; call it in `fixtures_db.database.Database.write`."""
    row.measured_utc = row.measured_utc.astimezone(UTC)
    return chained(session, row)


def chained(session: Session, row: Chained) -> Chained:
    """Chain a row that is otherwise complete and add it."""
    row.previous = newest_hash(session, type(row))
    row.sha256 = digest(row_text(row))
    session.add(row)
    session.flush()
    return row


def newest_hash(session: Session, table: type[Any]) -> str:
    """Return the hash of a chained table's newest row, 64 zeros where there is none."""
    found: str | None = session.scalars(select(table.sha256).order_by(table.id.desc()).limit(1)).first()
    return found or GENESIS


def in_force(rows: Sequence[Measured]) -> Measured | None:
    """Return the row measured last, of two at one moment the one added last; None of none."""
    return max(rows, key=lambda row: (row.measured_utc, row.id), default=None)


def owners_rows_in_force(owner: CubeRow | SlabRow, until: datetime | None = None) -> list[Any]:
    """Return what is in force of a cube or a slab, of what was measured ``until`` then.

    Of a cube that is the last certificate of each face; where there is none, its last measurement.
    """

    def held(rows: Sequence[Measured]) -> list[Measured]:
        return [row for row in rows if until is None or row.measured_utc <= until]

    if isinstance(owner, SlabRow):
        return _newest_of([held(owner.levels)])
    certificates = held(owner.certificates)
    faces = dict.fromkeys(row.resting for row in certificates)
    by_face = [[row for row in certificates if row.resting == face] for face in faces]
    return _newest_of(by_face) or _newest_of([held(owner.measurements)])


def _newest_of(groups: Sequence[Sequence[Measured]]) -> list[Any]:
    return [row for rows in groups if (row := in_force(rows)) is not None]


def date_owner(session: Session, owner: CubeRow | SlabRow) -> None:
    """Give a cube or a slab the dates of what is in force of it."""
    session.flush()
    session.expire(owner)
    if (dates := _dates(owner)) is not None:
        owner.certificate_date, owner.due_date = dates
    session.flush()
    session.expire(owner)


def _dates(owner: CubeRow | SlabRow) -> tuple[date, date | None] | None:
    """Return the day of what was measured last, and the first day on which what is in force is due."""
    if not (rows := owners_rows_in_force(owner)):
        return None
    due = [row.due_date for row in rows if row.due_date is not None]
    return max(row.measured_utc for row in rows).date(), min(due, default=None)


def verify_rows(
    session: Session,
    table: type[Chained],
    expected_head: str | None = None,
    others: Callable[[Chained], Iterable[ChainFault]] = lambda row: (),
) -> list[ChainFault]:
    """Return every row of a table that was altered, dropped or reordered since it was added.

    Rows dropped at the newest end show only against ``expected_head``, a hash that was kept elsewhere.
    ``others`` gives what else is wrong with a row.
    """
    word = ROW_TITLES[table]
    rows: Sequence[Chained] = session.scalars(select(table).order_by(table.id)).all()
    found = faults(Link(f"{word} {row.id}", row_text(row), row.previous, row.sha256) for row in rows)
    found += chain.from_iterable(map(others, rows))
    if expected_head not in {None, GENESIS, *(row.sha256 for row in rows)}:
        found.append(ChainFault(f"newest {word}", newest_hash(session, table), str(expected_head)))
    return found


def verify_dates(session: Session) -> list[ChainFault]:
    """Return every cube and slab whose dates are not those of what is in force of it."""
    found = list[ChainFault]()
    owners: list[CubeRow | SlabRow] = [*fixture_rows(session, CubeRow), *fixture_rows(session, SlabRow)]
    for owner in owners:
        stands = (owner.certificate_date, owner.due_date)
        if (is_due := _dates(owner)) is not None and is_due != stands:
            text = [f"certified {of}, due {due}" for of, due in (stands, is_due)]
            found.append(ChainFault(f"{KIND_NAMES[type(owner)]} {owner.id}", *text))
    return found


def row_text(row: Base) -> str:
    """Return the text that is hashed: a calibration's document, else every column but number and hash."""
    if isinstance(row, CalibrationRow):
        return row.document
    hashed = {
        column.key: getattr(row, column.key)
        for column in type(row).__table__.columns
        if column.key not in NOT_HASHED
        and not (column.key in HASHED_WHERE_GIVEN and getattr(row, column.key) is None)
    }
    return canonical(
        {key: value.isoformat() if isinstance(value, date) else value for key, value in hashed.items()}
    )


REFUSING_FUNCTION = "BEGIN RAISE EXCEPTION '% is append-only', TG_TABLE_NAME; END"
_ON_POSTGRESQL = """
SELECT t.tgname, replace(pg_get_triggerdef(t.oid, true), quote_ident(current_schema()) || '.', ''),
       t.tgenabled, btrim(p.prosrc)
FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid
WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace
UNION ALL SELECT rulename, 'rule', 'O', '' FROM pg_rules WHERE schemaname = current_schema()
"""


def append_only_tables() -> tuple[str, ...]:
    """Return the tables whose rows are chained."""
    return tuple(name for name, table in Base.metadata.tables.items() if "previous" in table.columns)


def on_sqlite(table: str) -> dict[str, str]:
    """Return the statements of a table's triggers by name."""
    refuse = f"BEGIN SELECT RAISE(ABORT, '{table} is append-only'); END"
    # INSERT OR REPLACE deletes without firing a DELETE trigger
    is_there = "id = NEW.id OR previous = NEW.previous OR sha256 = NEW.sha256"
    moments = {
        f"{table}_no_update": "UPDATE ON {}",
        f"{table}_no_delete": "DELETE ON {}",
        f"{table}_no_replace": f"INSERT ON {{}} WHEN EXISTS (SELECT 1 FROM {{}} WHERE {is_there})",
    }
    return {
        name: f"CREATE TRIGGER {name} BEFORE {moment.replace('{}', table)} {refuse}"
        for name, moment in moments.items()
    }


def on_postgresql(table: str) -> dict[str, str]:
    """Return the statements of a table's triggers by name; they call ``refuse_change``."""
    return {
        f"{table}_no_{action.lower()}": f"CREATE TRIGGER {table}_no_{action.lower()} BEFORE {action} ON {table} "
        f"FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()"
        for action in ("UPDATE", "DELETE", "TRUNCATE")  # ON CONFLICT DO UPDATE fires the one of UPDATE
    }


def trigger_faults(connection: Connection) -> list[ChainFault]:
    """Return every trigger that lacks, is switched off, does something else or was added by others."""
    is_sqlite = connection.dialect.name == "sqlite"
    made = on_sqlite if is_sqlite else on_postgresql
    expected = {name: sql for table in append_only_tables() for name, sql in made(table).items()}
    found = _on_sqlite_now(connection) if is_sqlite else _on_postgresql_now(connection)
    return [
        ChainFault(f"trigger {name}", found.get(name, "none"), expected.get(name, "none"))
        for name in sorted(expected.keys() | found.keys())
        if found.get(name) != expected.get(name)
    ]


def _on_sqlite_now(connection: Connection) -> dict[str, str]:
    rows = connection.execute(text("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'"))
    return {row.name: row.sql for row in rows}


def _on_postgresql_now(connection: Connection) -> dict[str, str]:
    return {
        name: f"{statement}{'' if state in {'O', 'A'} else ', disabled'}"
        f"{'' if source == REFUSING_FUNCTION else f', which runs {source}'}"
        for name, statement, state, source in connection.execute(text(_ON_POSTGRESQL))
    }
