"""PostgreSQL as the database of several stations: one writer at a time, as with SQLite.

A writer takes an advisory lock at its beginning, so that the newest row that it reads and chains to is still the
newest when it commits; whoever reads waits for nobody and sees one state.
"""

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.engine import URL

WRITER_LOCK = 0x464F47  # "FOG": the advisory lock's number, of this database alone


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
