"""Edits of an SQLite database's files: an older copy, a -wal that is gone or another's, a byte, the version."""

import random
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

from fixtures_db.database import open_db
from fixtures_db.errors import DatabaseError
from fixtures_db.stored_calibrations import accept_calibration
from fixtures_db.verification import Anchor, alterations, take_anchor
from tests.fixtures_db.factory import facts, solution
from tests.fixtures_db.filled_database import fill

NAMES = ("station.db", "station.db-wal")


class Copies:
    """A database's files as they were three times, each two calibrations later; the -wal is never emptied."""

    def __init__(self, home: Path) -> None:
        self.home = home
        with open_db(home / NAMES[0]) as database:
            with database.write() as session:
                fill(session)
            with database.engine.connect() as connection:
                connection.exec_driver_sql("ROLLBACK")
                connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)")
                connection.exec_driver_sql("BEGIN")
            for number in range(3):
                with database.write() as session:
                    for bias in (1e-3, 2e-3):
                        accept_calibration(session, solution(bias + number * 1e-4), facts("S1"))
                (home / str(number)).mkdir()
                _copy(home, home / str(number))
            with database.read() as session:
                self.anchor = take_anchor(session)

    def edited(self, where: Path, how: str, chance: random.Random) -> None:
        """Put an edited copy of the last state into a folder."""
        _copy(self.home / "2", where)
        older = self.home / str(chance.randrange(2))
        match how:
            case "older copy":
                _copy(older, where)
            case "-wal removed":
                (where / NAMES[1]).unlink()
            case "older -wal":
                shutil.copy(older / NAMES[1], where / NAMES[1])
            case "-wal cut":
                content = (where / NAMES[1]).read_bytes()
                (where / NAMES[1]).write_bytes(content[: chance.randrange(32, len(content) * 3 // 4)])
            case "byte of -wal" | "byte of file":
                file = where / NAMES[how == "byte of -wal"]
                content = bytearray(file.read_bytes())
                content[chance.randrange(100, len(content))] ^= 1 << chance.randrange(8)
                file.write_bytes(content)
            case "version":
                version = f"{chance.randrange(20):04d}"
                with closing(sqlite3.connect(where / NAMES[0])) as connection, connection:
                    connection.execute("UPDATE alembic_version SET version_num = ?", (version,))


def _copy(home: Path, to: Path) -> None:
    for name in NAMES:
        shutil.copy(home / name, to / name)


HOW = ("older copy", "-wal removed", "older -wal", "-wal cut", "byte of -wal", "byte of file", "version")


def meaning(file: Path) -> list[str]:
    """Return all that a database says."""
    with closing(sqlite3.connect(file)) as connection:
        return list(connection.iterdump())


def look(file: Path, anchor: Anchor) -> tuple[bool, bool]:
    """Return whether a database is found faulty, or refused, without an anchor and with it."""
    try:
        with open_db(file) as database, database.read() as session:
            alone = bool(alterations(session))
            return alone, alone or bool(alterations(session, anchor))
    except DatabaseError:
        return True, True


def try_file_edits(
    home: Path, count: int, chance: random.Random, record: Callable[[str, str, bool, bool], None]
) -> None:
    """Edit files ``count`` times, and tell each kind with what it did and whether it was found."""
    (home / "copies").mkdir()
    copies = Copies(home / "copies")
    (home / "whole").mkdir()
    _copy(copies.home / "2", home / "whole")
    before = meaning(home / "whole" / NAMES[0])
    for number in range(count):
        how = HOW[number % len(HOW)]
        where = home / f"file_{number}"
        where.mkdir()
        copies.edited(where, how, chance)
        edit = f"{how} {number}"
        alone, anchored = look(where / NAMES[0], copies.anchor)
        is_same = not anchored and meaning(where / NAMES[0]) == before
        record(how if not is_same else f"{how}, read as before", edit, alone, anchored)
        shutil.rmtree(where)
