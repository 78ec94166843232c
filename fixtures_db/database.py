"""Open the database, bring its schema up to date, and hand out transactions.

SQLite, a file, serves the processes of one station; PostgreSQL, by URL, several stations. With both an accepted
row survives a power cut, and a writer takes the lock at its beginning: two transactions that read and then write
never fail half-way, and never chain to the same row. SQLite: WAL, synchronous=FULL, a busy time-out. PostgreSQL: a
writer takes an advisory lock; whoever reads waits for nobody and sees one state.
"""

import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import platformdirs
from sqlalchemy import Connection, Engine, create_engine, event, inspect, text
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, DatabaseError, NoSuchModuleError, OperationalError
from sqlalchemy.orm import Session
from sqlalchemy.pool import ConnectionPoolEntry

from fixtures_db.errors import DatabaseBusy, NewerDatabase, NotADatabase, NotWritten, SchemaAltered
from fixtures_db.folder_on_disk import make_folder
from fixtures_db.journal import JournalledSession
from fixtures_db.migrations import HEAD, KNOWN
from fixtures_db.schema import Base

WRITER_LOCK = 0x464F47  # "FOG": the advisory lock's number, of this database alone
BUSY_TIMEOUT_S = 10.0
_IS_VERSION = re.compile(r"\d{4}")
# what SQLite and PostgreSQL say where a migration finds other tables than those of the version it begins at
_OTHER_TABLES = re.compile(
    r"already exists|no such (?:table|column)|duplicate (?:column|key)|UNIQUE|does not exist"
)


@dataclass(frozen=True, slots=True)
class Database:
    """An open database at the newest schema; close it, or use it in a ``with``."""

    url: str
    engine: Engine

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Yield a session that sees one consistent state and waits for nobody."""
        with Session(self.engine.execution_options(reads_only=True)) as session:
            yield session
            session.expunge_all()  # so that rows stay readable after the transaction

    @contextmanager
    def write(self) -> Iterator[Session]:
        """Yield a session that holds the write lock; commit at its end, roll back if the body raises.

        What it changes is written to the journal with it.

        Raises
        ------
        DatabaseBusy
            If another process keeps the lock for more than `BUSY_TIMEOUT_S`.
        NotWritten
            If the disk is full or refuses; nothing was changed.
        """
        try:
            with JournalledSession(self.engine, expire_on_commit=False) as session, session.begin():
                try:
                    session.connection()
                except OperationalError as error:
                    if "lock" not in str(error.orig):  # a file that may not be written, say
                        raise
                    raise DatabaseBusy(self.url, BUSY_TIMEOUT_S) from error
                yield session
        except OperationalError as error:
            raise NotWritten(self.url, str(error.orig)) from error

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()

    def __enter__(self) -> "Database":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def default_path() -> Path:
    """Return where the station keeps its database by default: the user's data directory."""
    return platformdirs.user_data_path("fog-station") / "station.db"


def open_db(where: str | Path | None = None) -> Database:
    """Open a database by path or URL, create it if it is not there, and upgrade its schema.

    Parameters
    ----------
    where : str, Path or None
        A file's path, or a URL such as ``sqlite:////var/lib/station.db`` or
        ``postgresql://station@host/fixtures``; None is `default_path`.

    Raises
    ------
    NotADatabase
        If it cannot be opened, is not a database, or stays locked for more than `BUSY_TIMEOUT_S`.
    NewerDatabase
        If its schema is newer than this code.
    SchemaAltered
        If its schema version is gone, doubled, foreign, or not that of its tables.
    NotWritten
        If the disk is full or fails.
    """
    url = _url(where)
    name = url.render_as_string(hide_password=True)
    try:
        if url.get_backend_name() == "sqlite" and url.database:
            make_folder(Path(url.database).absolute().parent)
        engine = _engine(url)
    except OSError as error:
        raise NotADatabase(name, f"{error.filename}: {error.strerror}") from error
    except (ArgumentError, NoSuchModuleError, ImportError) as error:
        raise NotADatabase(name, str(error)) from error
    try:
        _upgrade(engine, name)
    except DatabaseError as error:
        engine.dispose()
        if "disk" in str(error.orig):  # is full, or fails
            raise NotWritten(name, str(error.orig)) from error
        raise NotADatabase(name, str(error.orig)) from error
    except BaseException:
        engine.dispose()
        raise
    return Database(name, engine)


def _url(where: str | Path | None) -> URL:
    if isinstance(where, str) and "://" in where:
        try:
            return make_url(where)
        except ArgumentError as error:
            raise NotADatabase(where, str(error)) from error
    return URL.create("sqlite", database=str(where if where is not None else default_path()))


def _engine(url: URL) -> Engine:
    match url.get_backend_name():
        case "sqlite":
            return sqlite_engine(url, BUSY_TIMEOUT_S)
        case "postgresql":
            return postgresql_engine(url, BUSY_TIMEOUT_S)
    raise ArgumentError(f"found {url.get_backend_name()}, expected sqlite or postgresql")


def _revision(connection: Connection, name: str) -> str | None:
    """Return a database's schema version, None of an empty one; raise `SchemaAltered` where it is unclear."""
    there = set(inspect(connection).get_table_names())
    found: list[str] = []
    if "alembic_version" in there:
        found = sorted(map(str, connection.execute(text("SELECT version_num FROM alembic_version")).scalars()))
    if len(found) > 1:
        raise SchemaAltered(name, f"schema versions {', '.join(found)}", f"one, of {KNOWN[0]} to {HEAD}")
    if found:
        return found[0]
    if mine := sorted(there & Base.metadata.tables.keys()):
        wording = f"no schema version, but tables ({', '.join(mine[:3])})"
        raise SchemaAltered(name, wording, f"one of {KNOWN[0]} to {HEAD} in alembic_version")
    return None


def _upgrade(engine: Engine, name: str) -> None:
    with engine.execution_options(reads_only=True).connect() as connection:
        revision = _revision(connection, name)
    if revision == HEAD:
        return
    if revision is not None and revision not in KNOWN:
        if _IS_VERSION.fullmatch(revision) and revision > HEAD:
            raise NewerDatabase(name, revision, HEAD)
        raise SchemaAltered(name, f"schema version {revision!r}", f"one of {KNOWN[0]} to {HEAD}")
    from fixtures_db.migrations.upgrade import upgrade  # here: alembic takes 0.3 s to import

    with engine.begin() as connection:
        if _revision(connection, name) == HEAD:  # another process may have done it while this one waited
            return
        try:
            upgrade(connection)
        except DatabaseError as error:
            if _OTHER_TABLES.search(str(error.orig)) is None:
                raise
            found = f"schema version {revision or 'none'} with tables of another ({error.orig})"
            raise SchemaAltered(name, found, "tables of that version") from error


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

    Raise `ImportError` if psycopg, the extra ``postgres``, is not installed.
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
