"""The journal against the tables: its entries, summed up, are each row as it stands, and no other row.

What a calibration depends on is compared with the journal too: the rows that it used, by one hash for each kind
(unit, limits, campaign, cube, slab, site), and the limits of that day.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, select
from sqlalchemy.orm import Session

from fixtures_db.hash_chain import GENESIS, ChainFault, canonical, digest
from fixtures_db.imu_models import Limit
from fixtures_db.journal import (
    CARRY,
    DELETE,
    EVENTS,
    INSERT,
    NO_CONTENT,
    UNREADABLE,
    UPDATE,
    Head,
    contents,
    entry_text,
    journalled_tables,
)
from fixtures_db.schema import Base, CalibrationRow, JournalRow

Find = Callable[[str, str, Any], Iterable[tuple[str, str]]]  # table, column, value: keys and contents
OWNED = {  # by the campaign's column: the table that it names a row of, and the tables whose rows name that
    "cube_id": ("cubes", ("tolerance_items", "face_certificates", "cube_measurements")),
    "slab_id": ("slabs", ("slab_levels",)),
    "site_id": ("sites", ()),
}


def used_now(session: Session, model: str, serial: str, campaign_id: int | None) -> dict[str, str]:
    """Return the hashes as the database stands."""
    connection = session.connection()

    def find(table: str, column: str, value: Any) -> Iterable[tuple[str, str]]:
        rows = Base.metadata.tables[table]
        return contents(connection, rows, rows.columns[column] == value)

    return used_hashes(find, model, serial, campaign_id)


def used_hashes(find: Find, model: str, serial: str, campaign_id: int | None) -> dict[str, str]:
    """Return the SHA-256 over the rows of each kind, of a cube and a slab with all that was measured of them."""
    units = [row for row in find("imus", "serial", serial) if json.loads(row[1])["model"] == model]
    used = {"imu": units, "limits": list(find("imu_limits", "model", model))}
    campaigns = [] if campaign_id is None else list(find("campaigns", "id", campaign_id))
    for key, content in campaigns:
        used["campaign"] = [(key, content)]
        named = json.loads(content)
        for column, (table, parts) in OWNED.items():
            if (name := named.get(column)) is not None:
                owned = [row for part in parts for row in find(part, column, name)]
                used[column.removesuffix("_id")] = [*find(table, "id", name), *owned]
    return {kind: digest(canonical({"rows": sorted(list(row) for row in rows)})) for kind, rows in used.items()}


def grounds_faults(row: Mapping[str, Any] | None, head: Head, find: Find) -> list[ChainFault]:
    """Return what of a calibration does not follow from the rows that stood when it was stored.

    ``row`` has its number, its ``campaign_id`` and its document as text, None if it is gone, which other checks
    say. ``head`` is the journal's then, ``find`` finds its rows. The verdict is found again from the values judged
    and the limits that the journal had.
    """
    if row is None:
        return []
    name, document = f"calibration {row['id']}", json.loads(row["document"])
    model, used = document["model"], document.get("used")
    found = [ChainFault(name, f"journal {document.get('journal')}", f"{head._asdict()}")]
    found = found if document.get("journal") != head._asdict() else []
    expected = used_hashes(find, model, document["serial"], row["campaign_id"])
    found += [
        ChainFault(name, f"{kind} with sha256 {(used or {}).get(kind, 'none')}", f"{sha256} as on that day")
        for kind, sha256 in expected.items()
        if (used or {}).get(kind) != sha256
    ]
    if "verdict" in document:
        found += _verdict_faults(name, document, limits_as_found(find("imu_limits", "model", model)))
    return found


def carried_faults(row: Mapping[str, Any] | None) -> list[ChainFault]:
    """Return what is wrong with a calibration that was there before the journal: it cannot name an entry."""
    if row is None or not json.loads(row["document"]).keys() & {"journal", "used"}:
        return []
    found = "one that was there before the journal began"
    return [ChainFault(f"calibration {row['id']}", found, "an entry of when it was stored")]


def limits_as_found(rows: Iterable[tuple[str, str]]) -> list[Limit]:
    """Return limits in the order in which they were given, from keys and contents of their rows."""
    stated = sorted((json.loads(content) for _, content in rows), key=lambda one: one["id"])
    return [_limit(one) for one in stated]


def _limit(stated: Mapping[str, Any]) -> Limit:
    ends = stated.get("low"), stated.get("high")
    return Limit(stated["parameter"], *ends, stated["unit"], stated.get("guard_band", 0.0))


def _verdict_faults(name: str, document: Mapping[str, Any], limits: list[Limit]) -> list[ChainFault]:
    stated = [_limit(one) for one in document["limits"]]
    if stated != limits:
        lacking = [one.parameter for one in limits if one not in stated] or [one.parameter for one in stated]
        return [ChainFault(name, f"other limits, of {lacking[0]} for one", "those of that day")]
    judged = {one["parameter"]: one for one in document.get("judged", ())}
    if not judged.keys() >= {limit.parameter for limit in limits}:  # stored by hand: nobody says what was judged
        return []
    words = [_word(limit, judged[limit.parameter]) for limit in limits]
    verdict = next(
        (word for word in ("FAIL", "NOT_MEASURED") if word in words), "PASS" if words else "NOT_MEASURED"
    )
    return (
        []
        if verdict == document["verdict"]
        else [ChainFault(name, document["verdict"], f"{verdict} by its limits")]
    )


def _word(limit: Limit, judged: Mapping[str, Any]) -> str:
    if judged.get("unit") != limit.unit:
        return "NOT_MEASURED"
    low, high = limit.accepted(judged.get("std"))
    return "PASS" if low <= judged["value"] <= high else "FAIL"


_TABLE = JournalRow.metadata.tables[JournalRow.__tablename__]


@dataclass(frozen=True, slots=True)
class Entry:
    """What an entry of the journal says of a row."""

    number: int
    table: str
    key: str
    event: str
    content: str
    previous: str


@dataclass(slots=True)
class State:
    """The rows as the entries up to now leave them: by table and key each one's content."""

    tables: dict[str, dict[str, str]] = field(default_factory=dict)

    def find(self, table: str, column: str, value: Any) -> list[tuple[str, str]]:
        """Return keys and contents of the rows of a table that have a value."""
        stated = canonical({column: value})[1:-1]  # a row without this text has another value; a number may go on
        rows = [row for row in self.tables.get(table, {}).items() if stated in row[1]]
        return [row for row in rows if _loaded(row[1]).get(column) == value]

    def apply(self, entry: Entry) -> str | None:
        """Take an entry in; return what is wrong with it, None if it follows from those before."""
        rows = self.tables.setdefault(entry.table, {})
        is_there = entry.key in rows
        if entry.event not in EVENTS or is_there != (entry.event in {UPDATE, DELETE}):
            return f"{entry.event} of a row that is {'there' if is_there else 'not there'}"
        if entry.event == DELETE:
            del rows[entry.key]
            return None if entry.content == NO_CONTENT else "a deletion with a content"
        rows[entry.key] = entry.content
        return None


def entries(connection: Connection, faults: list[ChainFault]) -> Iterator[Entry]:
    """Yield the journal's entries; what is wrong with their chain is added to ``faults``."""
    head = Head(0, GENESIS)
    for row in connection.execute(select(_TABLE).order_by(_TABLE.c.id)).mappings():
        name = f"journal {row['id']}"
        if row["id"] != head.entries + 1:
            faults.append(ChainFault(name, f"number {row['id']}", f"{head.entries + 1}"))
        if row["previous"] != head.sha256:
            faults.append(ChainFault(name, f"previous {row['previous']}", head.sha256))
        if (actual := digest(entry_text(row))) != row["sha256"]:
            faults.append(ChainFault(name, f"text with sha256 {actual}", row["sha256"]))
        head = Head(row["id"], row["sha256"])
        yield Entry(row["id"], row["table_name"], row["row_key"], row["event"], row["content"], row["previous"])


def verify_journal(session: Session, kept: Head | None = None) -> list[ChainFault]:
    """Return all that differs between the journal and the tables, and what is wrong with the journal itself.

    Entries dropped at the newest end, or rewritten with all that follow, show only against ``kept``, a length and
    a hash that were kept elsewhere.
    """
    faults, state, connection = list[ChainFault](), State(), session.connection()
    calibrations = _calibrations(connection)
    for entry in entries(connection, faults):
        if entry.table == CalibrationRow.__tablename__:
            faults += _grounds(entry, calibrations.get(entry.key), state)
        if (wrong := state.apply(entry)) is not None:
            faults.append(ChainFault(f"journal {entry.number}", wrong, f"{' or '.join(EVENTS)} that follows"))
    faults += missing_entry(connection, kept or Head(0, GENESIS))
    known = {table.name: table for table in journalled_tables()}
    for name in sorted(known.keys() | state.tables.keys()):
        rows = list(contents(connection, known[name])) if name in known else []
        stored, counted = dict(rows), Counter(key for key, _ in rows)
        faults += [
            ChainFault(f"{name} {key}", f"{n} rows of that key", "one") for key, n in counted.items() if n > 1
        ]
        faults += _differences(name, stored, state.tables.get(name, {}))
    return faults


def missing_entry(connection: Connection, kept: Head) -> list[ChainFault]:
    """Return a fault if the entry of a number that was kept elsewhere is gone or has another hash.

    ``kept.sha256`` may be the first digits of it, as in `Head.code`.
    """
    if kept.entries == 0:
        return []
    found = connection.execute(select(_TABLE.c.sha256).where(_TABLE.c.id == kept.entries)).scalar()
    if found is not None and found.startswith(kept.sha256):
        return []
    return [ChainFault(f"journal {kept.entries}", found or "none", f"{kept.sha256} as kept elsewhere")]


def speaks_since(session: Session) -> tuple[datetime, int]:
    """Return when the journal begins, and how many rows it found there and carried over."""
    begun: datetime = session.execute(select(_TABLE.c.recorded_utc).order_by(_TABLE.c.id).limit(1)).scalar_one()
    return begun, len(session.execute(select(_TABLE.c.id).where(_TABLE.c.event == CARRY)).all())


def _grounds(entry: Entry, row: Mapping[str, Any] | None, state: State) -> list[ChainFault]:
    """Return what of a calibration does not follow from the entries before its own."""
    try:
        if entry.event == INSERT:
            return grounds_faults(row, Head(entry.number - 1, entry.previous), state.find)
        return carried_faults(row) if entry.event == CARRY else []
    except UNREADABLE:
        return [ChainFault(f"{entry.table} {entry.key}", "a document that cannot be read", "what was stored")]


def _calibrations(connection: Connection) -> dict[str, Mapping[str, Any]]:
    of = Base.metadata.tables[CalibrationRow.__tablename__].c
    rows = connection.execute(select(of.id, of.campaign_id, of.document)).mappings()
    return {str(row["id"]): dict(row) for row in rows}


def _differences(table: str, stored: Mapping[str, str], stated: Mapping[str, str]) -> Iterator[ChainFault]:
    for key in sorted(stored.keys() | stated.keys()):
        if (found := stored.get(key)) != (expected := stated.get(key)):
            yield ChainFault(f"{table} {key}", *_parted(found, expected))


def _parted(found: str | None, expected: str | None) -> Sequence[str]:
    """Return two contents without what they have in common."""
    if found is None or expected is None:
        return (found or "no row", expected or "none: the journal has no such row")
    now, then = _loaded(found), _loaded(expected)
    if not now or not then:
        return found, expected
    names = [name for name in sorted(now.keys() | then.keys()) if now.get(name) != then.get(name)]
    return [", ".join(f"{name} {each.get(name, 'empty')}" for name in names) for each in (now, then)]


def _loaded(content: str) -> dict[str, Any]:
    """Return what a content says by column, nothing of one that is no JSON object."""
    try:
        stated = json.loads(content)
    except UNREADABLE:
        return {}
    return stated if isinstance(stated, dict) else {}
