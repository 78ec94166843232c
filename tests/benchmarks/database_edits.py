"""Edit a database past the station: is it noticed?

Whoever edits may write to the file: triggers are out of the way, and put back. Each edit is looked at without an
anchor, and with one that was written before it; databases that nobody edited are looked at too.
"""

import os
import random
import tempfile
from collections import Counter
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import Column, Connection, Table
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from fixtures_db.database import Database, open_db
from fixtures_db.verification import alterations, take_anchor
from tests.benchmarks.edited_databases.declaration_edits import edit_declaration, edit_trigger
from tests.benchmarks.edited_databases.file_edits import try_file_edits
from tests.benchmarks.edited_databases.honest_databases import false_alarms
from tests.benchmarks.edited_databases.rewriting import cut, rewrite
from tests.benchmarks.edited_databases.row_edits import edits, make_edit
from tests.fixtures_db.edited import free_to_write, put_back
from tests.fixtures_db.filled_database import fill
from tests.proof.evidence import Figure, zero
from tests.with_postgres import URL

REWRITTEN, CUT, TRIGGER, DECLARED = OTHERS = ("rewritten", "cut off", "trigger", "declaration")


@dataclass
class Tally:
    """How many edits of a kind were made and noticed without an anchor; those missed with one too."""

    made: Counter[str] = field(default_factory=Counter)
    alone: Counter[str] = field(default_factory=Counter)
    missed: list[str] = field(default_factory=list)

    def add(self, other: "Tally") -> None:
        """Count another's too."""
        self.made += other.made
        self.alone += other.alone
        self.missed += other.missed

    def record(self, kind: str, edit: str, is_alone: bool, is_anchored: bool) -> None:
        """Count an edit."""
        self.made[kind] += 1
        self.alone[kind] += is_alone
        if not is_anchored and "read as before" not in kind:
            self.missed.append(f"{kind}: {edit}")


def try_edits(database: Database, count: int, seed: int) -> Tally:
    """Edit a filled database ``count`` times, each time taken back, and tell what was noticed."""
    chance, tally, every = random.Random(seed), Tally(), edits()
    with database.read() as session:
        assert alterations(session) == []
        anchor = take_anchor(session)
    chance.shuffle(every)
    for number in range(count):
        name, table, column = every[number % len(every)]
        kind = OTHERS[number // 10 % len(OTHERS)] if number % 10 == 9 else name
        with database.engine.connect() as connection:
            try:
                edit = _edited(connection, kind, table, column, chance)
            except DBAPIError:
                tally.record(f"{kind}, refused", f"{table.name}.{column.key}", True, True)
                continue
            if edit is None:
                continue
            with Session(bind=connection) as session:
                found = alterations(session)
                session.expire_all()
                tally.record(kind, edit, bool(found), bool(found or alterations(session, anchor)))
    return tally


def _edited(
    connection: Connection, kind: str, table: Table, column: Column[Any], chance: random.Random
) -> str | None:
    if kind == TRIGGER:
        return edit_trigger(connection, chance)
    if kind == DECLARED:
        return edit_declaration(connection, chance)
    free_to_write(connection)
    if kind == CUT:
        edit: str | None = cut(connection, chance)
    elif kind == REWRITTEN:
        edit = rewrite(connection, table, column, chance)
    else:
        edit = make_edit(kind, connection, table, column, chance)
    put_back(connection)
    return edit


def filled(where: str | Path) -> AbstractContextManager[Database]:
    """Return a database with something of everything."""
    database = open_db(where)
    with database.write() as session:
        fill(session)
    return database


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Make ``size`` edits on SQLite, a fifth as many on the server of `tests.with_postgres`, fewer of files."""
    tally, server = Tally(), os.environ.get(URL)
    with tempfile.TemporaryDirectory() as folder:
        for where, count in ((Path(folder) / "station.db", size), *([(server, size // 5)] if server else [])):
            with filled(where) as database:
                tally.add(try_edits(database, count, seed))
        try_file_edits(Path(folder), max(size // 20, 7), random.Random(seed), tally.record)
        alarms = false_alarms(Path(folder), max(size // 50, 4), random.Random(seed))
    return {
        "edits": Figure(tally.made.total()),
        "noticed without an anchor": Figure(tally.alone.total(), of=tally.made.total()),
        "missed against an anchor": zero(len(tally.missed)),
        "faults found in honest databases": zero(len(alarms)),
        "on PostgreSQL as well": Figure(bool(server)),
    }
