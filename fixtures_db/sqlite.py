"""SQLite as the station's database: WAL, synchronous=FULL, a busy time-out, the write lock from the beginning."""

import sqlite3
import time

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL
from sqlalchemy.pool import ConnectionPoolEntry


def sqlite_engine(url: URL, busy_timeout_s: float) -> Engine:
    """Return an engine whose writers take the lock at their beginning and wait ``busy_timeout_s`` for it."""
    # isolation_level=None leaves BEGIN to _begin: sqlite3 itself would begin late and never IMMEDIATE
    engine = create_engine(url, connect_args={"timeout": busy_timeout_s, "isolation_level": None})

    def configure(connection: sqlite3.Connection, _record: ConnectionPoolEntry) -> None:
        _use_wal(connection, busy_timeout_s)
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute("PRAGMA foreign_keys = ON")

    event.listen(engine, "connect", configure)
    event.listen(engine, "begin", _begin)
    return engine


def _use_wal(connection: sqlite3.Connection, busy_timeout_s: float) -> None:
    deadline = time.monotonic() + busy_timeout_s
    while connection.execute("PRAGMA journal_mode").fetchone()[0] not in {"wal", "memory"}:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError:  # this one change does not wait for another process by itself
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)


def _begin(connection: Connection) -> None:
    reads_only = connection.get_execution_options().get("reads_only", False)
    connection.exec_driver_sql("BEGIN" if reads_only else "BEGIN IMMEDIATE")
