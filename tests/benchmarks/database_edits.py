"""Edit a database past the station; is it noticed? `python -m tests.benchmarks.database_edits --count 5000`.

Edits are drawn from the schema itself, of every column of every table: `edited_databases.row_edits`. Whoever does
them may write to the file: triggers are out of the way, and put back. Beside them stand edits with all hashes made
to fit, the newest entries cut off, triggers, declarations, and the files of SQLite. Each is looked at without an
anchor, and with one that was written before it. ``--honest`` databases are looked at that nobody edited.
"""

import argparse
import os
import random
import tempfile
import time
from collections import Counter
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import Connection, text
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from fixtures_db.anchor import take_anchor
from fixtures_db.append_only_triggers import append_only_tables, on_sqlite
from fixtures_db.database import Database, open_db
from fixtures_db.hash_chain_verification import alterations
from fixtures_db.unreadable_rows import NO_ROW
from tests.benchmarks.edited_databases.declaration_edits import edit_declaration
from tests.benchmarks.edited_databases.file_edits import try_file_edits
from tests.benchmarks.edited_databases.honest_databases import false_alarms
from tests.benchmarks.edited_databases.rewriting import cut, rewrite
from tests.benchmarks.edited_databases.row_edits import EDITS, edits
from tests.benchmarks.edited_databases.trigger_edits import edit_trigger
from tests.fixtures_db.filled_database import fill
from tests.with_postgres import URL

REWRITTEN, CUT, TRIGGER, DECLARED = OTHERS = ("rewritten", "cut off", "trigger", "declaration")


@dataclass
class Tally:
    """How many edits of a kind were made, refused by the database, noticed alone and with an anchor."""

    made: Counter[str] = field(default_factory=Counter)
    alone: Counter[str] = field(default_factory=Counter)
    anchored: Counter[str] = field(default_factory=Counter)
    missed: list[str] = field(default_factory=list)
    unnamed: list[str] = field(default_factory=list)

    def tell(self, kind: str, said: str, is_alone: bool, is_anchored: bool) -> None:
        """Count an edit."""
        self.made[kind] += 1
        self.alone[kind] += is_alone
        self.anchored[kind] += is_anchored
        if not is_anchored and "read as before" not in kind:
            self.missed.append(f"{kind}: {said}")

    def lines(self) -> list[str]:
        """Return a line for each kind."""
        return [
            f"{kind:<28}{n:>7} edits {self.alone[kind]:>7} noticed {self.anchored[kind]:>7} with an anchor"
            for kind, n in sorted(self.made.items())
        ]


def free_to_write(connection: Connection) -> None:
    """Put triggers and references out of the way, as whoever owns the database can."""
    if connection.dialect.name == "postgresql":
        connection.execute(text("SET LOCAL session_replication_role = replica"))
        return
    connection.execute(text("PRAGMA defer_foreign_keys = ON"))
    for table in append_only_tables():
        for name in on_sqlite(table):
            connection.execute(text(f"DROP TRIGGER {name}"))


def put_back(connection: Connection) -> None:
    """Put the triggers back."""
    if connection.dialect.name == "sqlite":
        for table in append_only_tables():
            for statement in on_sqlite(table).values():
                connection.execute(text(statement))


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
                if kind == TRIGGER:
                    said: str | None = edit_trigger(connection, chance)
                elif kind == DECLARED:
                    said = edit_declaration(connection, chance)
                else:
                    free_to_write(connection)
                    said = _edited(connection, kind, every, number, chance)
                    put_back(connection)
            except DBAPIError:
                tally.tell(f"{kind}, refused", f"{table.name}.{column.key}", True, True)
                continue
            if said is None:
                continue
            with Session(bind=connection) as session:
                found = alterations(session)
                session.expire_all()
                tally.tell(kind, said, bool(found), bool(found or alterations(session, anchor)))
                tally.unnamed += [f"{said}: {fault}" for fault in found if fault.row == NO_ROW]
    return tally


def _edited(connection: Connection, kind: str, every: list, number: int, chance: random.Random) -> str | None:  # type: ignore[type-arg]
    name, table, column = every[number % len(every)]
    if kind == CUT:
        return cut(connection, chance)
    if kind == REWRITTEN:
        return rewrite(connection, table, column, chance)
    return EDITS[name](connection, table, column, chance)


def filled(where: str | Path) -> AbstractContextManager[Database]:
    """Return a database with something of everything."""
    database = open_db(where)
    with database.write() as session:
        fill(session)
    return database


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--files", type=int, default=70)
    parser.add_argument("--honest", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--postgresql", metavar="URL", help="or the server of python -m tests.with_postgres")
    options = parser.parse_args()
    server = options.postgresql or os.environ.get(URL)
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        with filled(server or Path(folder) / "station.db") as database:
            tally = try_edits(database, options.count, options.seed)
        if not server:
            try_file_edits(Path(folder), options.files, random.Random(options.seed), tally.tell)
        print(*tally.lines(), *tally.missed[:20], sep="\n")
        print(f"{len(tally.unnamed)} faults that name no row", *tally.unnamed[:5], sep="\n")
        n, missed = sum(tally.made.values()), len(tally.missed)
        alone = sum(tally.alone.values())
        print(f"{n} edits in {time.process_time() - began:.0f} s: {alone} noticed, {missed} missed with an anchor")
        if not server and options.honest:
            alarms = false_alarms(Path(folder), options.honest, random.Random(options.seed))
            print(f"{options.honest} honest databases: {len(alarms)} faults", *map(str, alarms[:5]), sep="\n")


if __name__ == "__main__":
    main()
