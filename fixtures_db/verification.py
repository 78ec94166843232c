"""What a database can say about whether it was altered.

An `Anchor` holds the heads of its hash chains: kept elsewhere, they show what was dropped or rewritten before
them. What cannot be read is named: tables are read whole, and row by row where one cannot be.

`verify_storage` checks that the database's file is whole, and its tables and values are as the station makes them.
A table that others built again may hold the same and refuse less. Each value has one form in which the station
writes it.
"""

import json
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from sqlalchemy import (
    Column,
    ColumnElement,
    Connection,
    Dialect,
    ForeignKeyConstraint,
    Inspector,
    Table,
    UniqueConstraint,
    inspect,
    select,
    text,
)
from sqlalchemy import text as sql
from sqlalchemy.exc import SAWarning
from sqlalchemy.orm import Session
from sqlalchemy.types import NullType

from fixtures_db.append_only_rows import ROW_TITLES, newest_hash, trigger_faults, verify_dates, verify_rows
from fixtures_db.campaigns import manifest_head, verify_steps
from fixtures_db.hash_chain import GENESIS, ChainFault
from fixtures_db.imu_models import verify_effects
from fixtures_db.issued_certificates import verify_issued
from fixtures_db.journal import UNREADABLE, Head, contents, journal_head
from fixtures_db.journal_verification import verify_journal
from fixtures_db.migrations import HEAD
from fixtures_db.schema import (
    Base,
    CalibrationRow,
    CampaignRow,
    CubeMeasurementRow,
    CubeRow,
    EffectEventRow,
    FaceCertificateRow,
    IssuedCertificateRow,
    SignedFileRow,
    SlabLevelRow,
    SlabRow,
    StepRow,
)
from fixtures_db.stored_calibrations import verify_chain

Declared = dict[str, str]  # of a table: "column id", "key", "reference imu_id", ... as text
# what of a declaration of SQLite no inspector reports; the station uses none of it
_UNSEEN = re.compile(r"\b(AUTOINCREMENT|CHECK|COLLATE|CONFLICT|DEFAULT|DEFERR\w+|STRICT|VIRTUAL|WITHOUT)\b", re.I)
_DECLARED = sql("SELECT type, name, tbl_name, sql FROM sqlite_master WHERE sql IS NOT NULL")
_FAULTLESS = set[tuple[tuple[str, ...], ...]]()  # what SQLite reports of tables that were found as made


def declaration_faults(connection: Connection) -> list[ChainFault]:
    """Return what of each table is declared otherwise; the order of columns and constraints' names have no say."""
    if connection.dialect.name != "sqlite":
        return list(_declared_otherwise(connection))
    declared = tuple(map(tuple, connection.execute(_DECLARED)))
    if declared in _FAULTLESS:
        return []
    if not (found := [*_declared_otherwise(connection), *_unseen_options(declared)]):
        _FAULTLESS.add(declared)
    return found


def _declared_otherwise(connection: Connection) -> Iterator[ChainFault]:
    known = inspect(connection)
    for name, table in Base.metadata.tables.items():
        found, expected = _as_found(known, name, connection.dialect), _as_made(table, connection.dialect)
        for what in sorted(found.keys() | expected.keys()):
            if (now := found.get(what)) != (made := expected.get(what)):
                yield ChainFault(f"table {name}", f"{what} {now or 'none'}", f"{what} {made or 'none'}")


def version_faults(connection: Connection) -> Iterator[ChainFault]:
    """Yield what is wrong with the schema version, of which there is one."""
    if not inspect(connection).has_table("alembic_version"):
        yield ChainFault("alembic_version", "no table", f"version {HEAD}")
        return
    there = sorted(map(str, connection.execute(sql("SELECT version_num FROM alembic_version")).scalars()))
    if there != [HEAD]:
        yield ChainFault("alembic_version", f"version {', '.join(there) or 'none'}", f"version {HEAD}")


def _as_made(table: Table, dialect: Dialect) -> Declared:
    made = {f"column {one.name}": _column(one, dialect) for one in table.columns}
    made["key"] = ", ".join(one.name for one in table.primary_key)
    for each in table.constraints:
        match each:
            case UniqueConstraint():
                made[f"unique {_names(each.columns.keys())}"] = "yes"
            case ForeignKeyConstraint():
                to = ", ".join(one.column.name for one in each.elements)
                made[f"reference {_names(each.columns.keys())}"] = f"{each.referred_table.name} ({to})"
    for index in table.indexes:
        made[f"index {index.name}"] = _names(index.columns.keys())
    return made


def _as_found(known: Inspector, name: str, dialect: Dialect) -> Declared:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SAWarning)  # of an index by an expression: `_unseen_options` names it
        columns, indices = known.get_columns(name), known.get_indexes(name)
    found = {f"column {one['name']}": _found_column(one, dialect) for one in columns}
    found["key"] = ", ".join(known.get_pk_constraint(name)["constrained_columns"])
    for unique in known.get_unique_constraints(name):
        found[f"unique {_names(unique['column_names'])}"] = f"yes{_options(unique.get('dialect_options'))}"
    for key in known.get_foreign_keys(name):
        to = ", ".join(key["referred_columns"])
        wording = f"{key['referred_table']} ({to}){_options(key.get('options'))}"
        found[f"reference {_names(key['constrained_columns'])}"] = wording
    for index in indices:
        if not index.get("duplicates_constraint"):
            unique_too = " UNIQUE" if index["unique"] else ""
            on = _names([str(one) for one in index["column_names"]])
            found[f"index {index['name']}"] = f"{on}{unique_too}{_options(index.get('dialect_options'))}"
    return found | {f"check {one['name']}": one["sqltext"] for one in known.get_check_constraints(name)}


def _column(column: Column[Any], dialect: Dialect) -> str:
    counts = dialect.name == "postgresql" and column is column.table.autoincrement_column
    return _declared(column.type.compile(dialect), bool(column.nullable), "counted" if counts else None)


def _found_column(found: Any, dialect: Dialect) -> str:
    default = found["default"]
    if default is not None and found.get("autoincrement") is True:
        default = "counted"
    others = _options({name: found.get(name) for name in ("computed", "identity")})
    kind = "of no type" if isinstance(found["type"], NullType) else found["type"].compile(dialect)
    return _declared(kind, found["nullable"], default) + others


def _declared(kind: str, nullable: bool, default: str | None) -> str:
    return f"{kind}{'' if nullable else ' NOT NULL'}{'' if default is None else f' DEFAULT {default}'}"


def _names(columns: list[str]) -> str:
    return ", ".join(sorted(columns))


def _options(wording: Any) -> str:
    return "".join(f" {name} {value}" for name, value in sorted((wording or {}).items()) if value)


def _unseen_options(declared: tuple[tuple[str, ...], ...]) -> Iterator[ChainFault]:
    known = {index.name for table in Base.metadata.tables.values() for index in table.indexes}
    for kind, name, table, made in declared:
        if table not in Base.metadata.tables:
            continue
        if kind == "index" and name not in known:
            yield ChainFault(f"table {table}", f"index {name}", f"index {name} none")
        elif kind == "table" and (word := _UNSEEN.search(made)) is not None:
            yield ChainFault(f"table {table}", f"declared with {word[0]}", "declared as the station does")


def verify_storage(session: Session) -> list[ChainFault]:
    """Return what is wrong with triggers, tables, pages and references, and values in a form nobody wrote.

    Of PostgreSQL's pages and forms the server itself takes care.
    """
    connection = session.connection()
    found = [*trigger_faults(connection), *_views(connection), *version_faults(connection)]
    found += declaration_faults(connection)
    if connection.dialect.name == "sqlite":
        found += _damage(connection)
        for table in Base.metadata.sorted_tables:
            found += _other_forms(connection, table)
    return found


def missing_tables(connection: Connection) -> list[ChainFault]:
    """Return the tables that are not there: nothing else can be read then."""
    there = set(inspect(connection).get_table_names())
    return [ChainFault(f"table {name}", "none", "one") for name in Base.metadata.tables if name not in there]


def _views(connection: Connection) -> Iterator[ChainFault]:
    """Yield the views there are, by which a name may mean another table."""
    for name in inspect(connection).get_view_names():
        yield ChainFault(f"view {name}", "a view", "none: the station makes none")


def _damage(connection: Connection) -> Iterator[ChainFault]:
    for wording in connection.execute(text("PRAGMA integrity_check(3)")).scalars():
        if wording != "ok":
            yield ChainFault("database file", wording, "a whole one")
    for row in connection.execute(text("PRAGMA foreign_key_check")):
        yield ChainFault(f"{row[0]} {row[1]}", f"a row of {row[2]} that is not there", "one that is")
    if (mode := connection.execute(text("PRAGMA journal_mode")).scalar()) not in {"wal", "memory"}:
        yield ChainFault("database file", f"journal mode {mode}", "wal")


def _other_forms(connection: Connection, table: Table) -> Iterator[ChainFault]:
    """Yield the values that read as they should and are stored otherwise: a flag of 2, a day as a moment."""
    columns = ", ".join(f'"{column.name}"' for column in table.columns)
    stored = connection.exec_driver_sql(f'SELECT {columns} FROM "{table.name}"').all()
    for at, column in enumerate(table.columns):
        impl = column.type.dialect_impl(connection.dialect)
        read, written = impl.result_processor(connection.dialect, None), impl.bind_processor(connection.dialect)
        for row in stored:
            try:
                value = read(row[at]) if read is not None else row[at]
                form = written(value) if written is not None and value is not None else value
            except UNREADABLE:
                form = f"a value of type {column.type!r}"
            if (type(form), form) != (type(row[at]), row[at]):
                yield ChainFault(f"{table.name} {row[0]}", f"{column.name} stored as {row[at]!r}", repr(form))


_HEADS: dict[str, type[Any]] = {
    "calibration": CalibrationRow, "certificate": FaceCertificateRow, "measurement": CubeMeasurementRow,
    "level": SlabLevelRow, "issued": IssuedCertificateRow, "signed": SignedFileRow, "effect": EffectEventRow,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Anchor:
    """The newest hash of calibrations, face certificates, levels, measured cubes, issued and signed, effects.

    ``journal`` is the hash of the newest entry of the journal, ``entries`` its number. ``manifests`` holds, by
    campaign folder, how many steps were accepted and the head of their chain.
    """

    calibration: str = GENESIS
    certificate: str = GENESIS
    level: str = GENESIS
    measurement: str = GENESIS
    issued: str = GENESIS
    signed: str = GENESIS
    effect: str = GENESIS
    journal: str = GENESIS
    entries: int = 0
    manifests: Mapping[str, tuple[int, str]] = field(default_factory=dict)

    @property
    def code(self) -> str:
        """The journal's length and the begin of its newest hash, as printed."""
        return Head(self.entries, self.journal).code


def take_anchor(session: Session) -> Anchor:
    """Return the heads as they are; a campaign being recorded, which may still be cancelled, is left out."""
    head = journal_head(session)
    ended = select(CampaignRow).where(CampaignRow.state != "recording").order_by(CampaignRow.id)
    return Anchor(
        **{name: newest_hash(session, table) for name, table in _HEADS.items()},
        journal=head.sha256,
        entries=head.entries,
        manifests={row.folder: (len(row.steps), row.manifest_sha256) for row in session.scalars(ended)},
    )


def missing_manifests(session: Session, manifests: Mapping[str, tuple[int, str]]) -> list[ChainFault]:
    """Return every campaign of an anchor that is gone, or whose steps do not begin with those of then."""
    rows, found = {row.folder: row for row in session.scalars(select(CampaignRow))}, list[ChainFault]()
    for folder, (steps, sha256) in manifests.items():
        if (row := rows.get(folder)) is None:
            found.append(ChainFault(f"campaign {folder}", "none", f"one of {steps} steps as in the anchor"))
        elif (head := manifest_head(row.steps[:steps])) != sha256:
            found.append(ChainFault(f"steps of campaign {folder}", f"head {head}", f"{sha256} as in the anchor"))
    return found


NO_ROW = "a row of the database"


def unreadable_row(session: Session, tables: tuple[Any, ...]) -> str:
    """Return table and key of the first row that cannot be read, else the tables that hold it."""
    connection = session.connection()
    for table in (Base.metadata.tables[one.__tablename__] for one in tables):
        if _is_read(connection, table):
            continue
        names = ", ".join(f'"{one.name}"' for one in table.primary_key)
        for key in connection.execute(text(f'SELECT {names} FROM "{table.name}"')).all():
            which = [one == value for one, value in zip(table.primary_key, key, strict=True)]
            if not _is_read(connection, table, *which):
                return f"{table.name} {', '.join(map(str, key))}"
    is_any = len(tables) == len(Base.metadata.tables)
    return NO_ROW if is_any else " or ".join(one.__tablename__ for one in tables)


def _is_read(connection: Connection, table: Table, *which: ColumnElement[bool]) -> bool:
    try:
        for _, content in contents(connection, table, *which):
            json.loads(content)
        if "document" in table.columns:
            for document in connection.execute(select(table.c.document).where(*which)).scalars():
                json.loads(document)
    except UNREADABLE:
        return False
    return True


def _chains() -> Iterator[tuple[str, type[Any], Callable[..., list[ChainFault]]]]:
    """Yield the chained tables by their name in an anchor, with the check of each."""
    own = {CalibrationRow: verify_chain, IssuedCertificateRow: verify_issued, EffectEventRow: verify_effects}
    for name, table in _HEADS.items():
        yield name, table, own.get(table) or partial(verify_rows, table=table)


CHAINED = tuple(ROW_TITLES)
Check = Callable[[Session], list[ChainFault]]
_EVERY = tuple(mapper.class_ for mapper in Base.registry.mappers)


def alterations(session: Session, anchor: Anchor | None = None) -> list[ChainFault]:
    """Return whatever disagrees with what was stored: a chain, a date, a row that the journal has otherwise.

    Entries dropped at the newest end show only against an ``anchor`` that was kept elsewhere.
    """
    kept = Anchor() if anchor is None else anchor
    if lost := missing_tables(session.connection()):
        return lost
    checks: tuple[tuple[Check, tuple[Any, ...]], ...] = (
        *((partial(check, expected_head=getattr(kept, name)), (table,)) for name, table, check in _chains()),
        (verify_dates, (CubeRow, SlabRow)),
        (verify_steps, (CampaignRow, StepRow)),
        (partial(missing_manifests, manifests=kept.manifests), (CampaignRow, StepRow)),
        (partial(verify_journal, kept=Head(kept.entries, kept.journal)), _EVERY),
        (verify_storage, _EVERY),
    )
    found = list[ChainFault]()
    for check, tables in checks:
        try:
            found += check(session)
        except UNREADABLE:
            found.append(ChainFault(unreadable_row(session, tables), "what cannot be read", "what was stored"))
    return found


def missing_head(session: Session, sha256: str) -> list[ChainFault]:
    """Return a fault if no row has a hash that was kept elsewhere, printed on a report or certificate."""
    if sha256 == GENESIS or sha256 in stored_hashes(session, sha256):
        return []
    return [ChainFault("stored rows", "none with the hash given", sha256)]


def stored_hashes(session: Session, digits: str) -> set[str]:
    """Return the hashes that begin with ``digits``: of chained rows, and of the accepted steps of campaigns."""
    columns: list[Any] = [table.sha256 for table in CHAINED] + [CampaignRow.manifest_sha256]
    return {one for column in columns for one in session.scalars(select(column).where(column.startswith(digits)))}
