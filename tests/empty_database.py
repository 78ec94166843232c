"""A database of a test's own, empty, with the newest schema: migrations run once in each process of tests."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from fixtures_db.database import Database, open_db


def empty_db(file: Path) -> Database:
    """Open a new SQLite database at ``file``: a copy takes 5 ms of processor time, the migrations 100 ms."""
    assert not file.exists()
    file.write_bytes(_content())
    return open_db(file)


@cache
def _content() -> bytes:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "station.db"
        open_db(file).close()
        assert not file.with_name("station.db-wal").exists()
        return file.read_bytes()
