"""What a state of the disk means to whoever reads it: two states of one meaning need one check.

A database means the rows that SQLite recovers from file and log, found anew for each state. A file whose name
begins with a dot is aside or a lock: it is taken away unread, so that its name alone counts.
"""

import hashlib
import shutil
import sqlite3
from pathlib import Path

from tests.benchmarks.power_cuts.disk_models import CrashState

DATA = "data/"
MEMORY_MAPPED = "-shm"


class Meaning:
    """Finds what states mean; a database that was seen before is not recovered again."""

    def __init__(self, home: Path) -> None:
        self._folder = home.parent / "recovered"
        self._rows: dict[bytes, bytes] = {}
        self.recovered = 0

    def of(self, state: CrashState) -> bytes:
        """Return a hash of a state's meaning."""
        whole = hashlib.blake2b(f"{len(state.said)}".encode(), digest_size=16)
        database = {
            name: content for name, content in state.files.items() if name.startswith(DATA) and content is not None
        }
        for name in sorted(set(state.files) - set(database)):
            content = state.files[name]
            whole.update(name.encode() + (b"/" if content is None else b"\0"))
            if content is not None and not name.rpartition("/")[2].startswith("."):
                whole.update(hashlib.blake2b(content, digest_size=16).digest())
        key = hashlib.blake2b(digest_size=16)
        for name in sorted(database):
            if not name.endswith(MEMORY_MAPPED):  # truncated by whoever opens first
                key.update(name.encode() + b"\0" + database[name])
        if key.digest() not in self._rows:
            self._rows[key.digest()] = self._recovered({name[len(DATA) :]: one for name, one in database.items()})
            self.recovered += 1
        whole.update(self._rows[key.digest()])
        return whole.digest()

    def _recovered(self, files: dict[str, bytes]) -> bytes:
        """Return a hash of all rows of a database, and of what its own check says."""
        if not files:
            return b"none"
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir()
        for name, content in files.items():
            (self._folder / name).write_bytes(content)
        path, found = self._folder / "station.db", hashlib.blake2b(digest_size=16)
        if not path.exists():
            return b"no database"
        connection = sqlite3.connect(path)
        try:
            found.update(repr(connection.execute("PRAGMA integrity_check").fetchall()).encode())
            schema = connection.execute("SELECT name, sql FROM sqlite_master ORDER BY name").fetchall()
            found.update(repr(schema).encode())
            tables = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchall()
            for (name,) in sorted(tables):
                found.update(repr(connection.execute(f"SELECT * FROM {name}").fetchall()).encode())
        except sqlite3.DatabaseError as error:
            found.update(repr(error).encode())
        finally:
            connection.close()
        return found.digest()
