"""SQLAlchemy engines whose writers take the lock at their beginning.

SQLite: WAL, synchronous=FULL, a busy time-out. PostgreSQL, for several stations: a writer takes an advisory lock,
so that the newest row that it reads and chains to is still the newest when it commits; whoever reads waits for
nobody and sees one state.
"""

import sqlite3
import time

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL
from sqlalchemy.pool import ConnectionPoolEntry

WRITER_LOCK = 0x464F47  # "FOG": the advisory lock's number, of this database alone


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


def postgresql_engine(url: URL, busy_timeout_s: float) -> Engine:
    """Return an engine whose writers take the lock at their beginning and wait ``busy_timeout_s`` for it.

    Raises
    ------
    ImportError
        If psycopg, the extra ``postgres``, is not installed.
    """
    if url.drivername == "postgresql":
        url = url.set(drivername="postgresql+psycopg")
    engine = create_engine(url, pool_pre_ping=True)  # a server may have restarted since the last transaction

    def begin(connection: Connection) -> None:
        if connection.get_execution_options().get("reads_only", False):
            connection.exec_driver_sql("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ READ ONLY")
        else:
            connection.exec_driver_sql(f"SET LOCAL lock_timeout = '{round(1e3 * busy_timeout_s)}ms'")
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({WRITER_LOCK})")

    event.listen(engine, "begin", begin)
    return engine
