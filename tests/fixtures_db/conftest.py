import os
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import URL, create_engine, make_url, text

from fixtures_db.database import Database, open_db
from fixtures_db.verification import alterations
from tests.fixtures_db.filled_database import fill
from tests.with_postgres import URL as SERVER


@pytest.fixture(scope="session")
def postgresql() -> Iterator[URL]:
    """A database of this worker's own: a writer's lock is for all schemas of a database."""
    if not (server := os.environ.get(SERVER)):
        pytest.skip(f"no PostgreSQL: {SERVER} is not set; `make test-postgres` starts a server")
    name = f"worker_{uuid.uuid4().hex}"
    engine = create_engine(make_url(server).set(drivername="postgresql+psycopg"), isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name}"))
    yield make_url(server).set(database=name)
    with engine.connect() as connection:
        connection.execute(text(f"DROP DATABASE {name} WITH (FORCE)"))
    engine.dispose()


@pytest.fixture(params=["sqlite", "postgresql"])
def db_url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Where an empty database can be made: a file, or a schema of its own on the server."""
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'station.db'}"
        return
    url: URL = request.getfixturevalue("postgresql")
    name = f"test_{uuid.uuid4().hex}"
    engine = create_engine(url.set(drivername="postgresql+psycopg"))
    with engine.begin() as connection:
        connection.execute(text(f"CREATE SCHEMA {name}"))
    try:
        yield url.update_query_dict({"options": f"-csearch_path={name}"}).render_as_string(False)
    finally:
        with engine.begin() as connection:
            connection.execute(text(f"DROP SCHEMA {name} CASCADE"))
        engine.dispose()


@pytest.fixture
def db(db_url: str) -> Iterator[Database]:
    with open_db(db_url) as opened:
        yield opened


@pytest.fixture
def sqlite_db(tmp_path: Path) -> Iterator[Database]:
    with open_db(tmp_path / "station.db") as opened:
        yield opened


@pytest.fixture(scope="session")
def filled_file(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A file of SQLite with something of everything, made once."""
    file = tmp_path_factory.mktemp("filled") / "station.db"
    with open_db(file) as opened, opened.write() as session:
        fill(session)
    assert not file.with_name("station.db-wal").exists()
    return file.read_bytes()


@pytest.fixture
def filled(db_url: str, filled_file: bytes) -> Iterator[Database]:
    """A database with something of everything."""
    if (file := make_url(db_url).database) and db_url.startswith("sqlite"):
        Path(file).write_bytes(filled_file)
    with open_db(db_url) as opened:
        if opened.engine.dialect.name != "sqlite":
            with opened.write() as session:
                fill(session)
        yield opened


@pytest.fixture
def sqlite_filled(tmp_path: Path, filled_file: bytes) -> Iterator[Database]:
    (tmp_path / "station.db").write_bytes(filled_file)
    with open_db(tmp_path / "station.db") as opened:
        yield opened


@pytest.fixture(scope="module")
def rolled_back(tmp_path_factory: pytest.TempPathFactory, filled_file: bytes) -> Iterator[Database]:
    """A filled database of SQLite for tests that leave nothing in it."""
    file = tmp_path_factory.mktemp("rolled_back") / "station.db"
    file.write_bytes(filled_file)
    with open_db(file) as opened:
        yield opened
        with opened.read() as session:
            assert alterations(session) == []
