"""What is altered, dropped or reordered, `station verify` finds.

A campaign is recorded, solved and stored, fixtures are certified, an anchor is written. Then one thing at a time
is changed: a byte of a column, a row or two rows of the database; a byte, a line or two lines of the calibration's
file, of a certificate, of an export or of the recording's files; a file. Harmless is what reads as it did before:
the blank between day and hour as another letter, two lines of SHA256SUMS in another order.
"""

import random
import tempfile
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from sqlalchemy import text
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from fixtures_db.anchor import take_anchor
from fixtures_db.append_only_triggers import append_only_tables
from fixtures_db.database import Database, open_db
from fixtures_db.fixture_transfer import dump
from fixtures_db.hash_chain_verification import alterations
from fixtures_db.stored_calibrations import accept_calibration
from station import cli
from station.files.fixture_files.csv_folder import write_csv
from station.files.fixture_files.toml_file import to_toml
from station.files.sha256sums import read_hashes
from station.results.campaign_results import make_results, store
from station.results.certificate.issuing import issue
from tests.fixtures_db.factory import facts, fill_fixtures, protect_again, solution, unprotect
from tests.proof.evidence import Figure, zero
from tests.station.guide.stored import recorded
from tests.station.results.certificate.factory import accepted, laboratory

COLUMNS = {  # what the chains cover; of the others docs/fixtures.md says so
    "calibrations": "imu_id campaign_id accepted_utc code_version inputs document previous sha256",
    "face_certificates": "cube_id resting up_tilt_1_rad up_tilt_2_rad covariance_11_rad2 covariance_12_rad2 "
    "covariance_22_rad2 source measured_utc due_date previous sha256",
    "cube_measurements": "cube_id values_rad covariance_rad2 sources measured_utc due_date previous sha256",
    "slab_levels": "slab_id tilt_east_rad tilt_north_rad std_east_rad std_north_rad source measured_utc due_date "
    "previous sha256",
    "steps": "campaign_id name file sha256 superseded",
    "campaigns": "folder manifest_sha256",
    "certificates": "number replaces calibration_sha256 issued_utc laboratory html html_sha256 previous sha256",
}


class Station:
    """A station's database and files, whole; each mutation is taken back."""

    def __init__(self, home: Path, chance: random.Random) -> None:
        self.home, self.chance = home, chance
        self.folder = home / "campaign"
        with open_db(home / "station.db") as database:
            recorded(self.folder, database)
            store(make_results(self.folder, database), database)
            with database.write() as session:
                fill_fixtures(session)
                for i in range(4):
                    accept_calibration(session, solution(i * 1e-3), facts(f"S{i % 2}"))
                for _ in range(2):
                    accepted(session)
            self.certificate = home / "certificate.html"
            for why in ("", "the customer's address was wrong"):
                self.certificate.write_text(issue(database, "S0101", laboratory(), why).html)
            with database.read() as session:
                rows, self.anchor = dump(session), take_anchor(session)
            (home / "export.toml").write_text(to_toml(rows))
            write_csv(home / "export", rows)

    def verify(self, what: Path) -> int:
        """Return the exit code of `station verify`."""
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            return cli.run(["verify", str(what), "--db", str(self.home / "station.db")])

    def in_database(self, database: Database) -> str:
        """Change a row and take it back."""
        table = self.chance.choice(list(COLUMNS))
        with database.engine.connect() as connection, Session(bind=connection) as session:
            session.execute(text("PRAGMA defer_foreign_keys = ON"))
            before = meaning(session, table)
            try:
                unprotect(session, table)
                change = self._change(session, table)
                if table in append_only_tables():
                    protect_again(session, table)
            except DBAPIError:
                return "found"  # the database itself refuses it
            found = bool(alterations(session, self.anchor))
            is_same = not found and meaning(session, table) == before
            session.rollback()
        return "found" if found else "harmless" if is_same else f"MISSED: {change}"

    def _change(self, session: Session, table: str) -> str:
        ids = session.scalars(text(f"SELECT id FROM {table}")).all()
        one = self.chance.choice(ids)
        how = self.chance.choice(("alter", "alter", "drop", "reorder"))
        if how == "drop":
            session.execute(text(f"DELETE FROM {table} WHERE id = {one}"))
            return f"{table} {one} dropped"
        if how == "reorder" and len(ids) > 1:
            other = self.chance.choice([i for i in ids if i != one])
            for was, now in ((one, -1), (other, one), (-1, other)):
                session.execute(text(f"UPDATE {table} SET id = {now} WHERE id = {was}"))
            return f"{table} {one} and {other} swapped"
        column = self.chance.choice(COLUMNS[table].split())
        value = session.scalar(text(f"SELECT {column} FROM {table} WHERE id = {one}"))
        new = self._other(value)
        session.execute(text(f"UPDATE {table} SET {column} = :new WHERE id = {one}"), {"new": new})
        return f"{table} {one} {column}: {value!r} to {new!r}"

    def _other(self, value: object) -> object:
        match value:
            case str():
                at = self.chance.randrange(len(value))
                return value[:at] + chr(ord(value[at]) ^ (1 << self.chance.randrange(5))) + value[at + 1 :]
            case float():
                return value * (1 + 2.0**-52 * self.chance.choice((1, 2, 2**20, 2**50)))
            case int():
                return value + self.chance.choice((-1, 1))
        return 1

    def in_file(self) -> str:
        """Change a file and take it back."""
        toml, export, document = self.home / "export.toml", self.home / "export", self.folder / "calibration.json"
        recording = [self.folder / name for name in ("campaign.toml", "SHA256SUMS", *read_hashes(self.folder))]
        exported, issued = (export, list(export.iterdir())), (self.certificate, [self.certificate])
        what, files = self.chance.choice(
            ((toml, [toml]), exported, (self.folder, recording), (document, [document]), issued)
        )
        file = self.chance.choice(sorted(files))
        content = file.read_bytes()
        how = self.chance.choice((self._byte, self._cut, self._dropped_line, self._swapped_lines, None))
        if how is None:
            file.unlink()
        else:
            file.write_bytes(how(content))
        is_same = how is not None and file.read_bytes() == content
        is_reordered = file.name == "SHA256SUMS" and how == self._swapped_lines
        found = self.verify(what) != 0
        file.write_bytes(content)
        said = f"MISSED in {file.name}, {how.__name__ if how else 'dropped'}"
        return "found" if found else "harmless" if is_same or is_reordered else said

    def _byte(self, content: bytes) -> bytes:
        at = self.chance.randrange(len(content))
        return content[:at] + bytes([content[at] ^ (1 << self.chance.randrange(8))]) + content[at + 1 :]

    def _cut(self, content: bytes) -> bytes:
        return content[: self.chance.randrange(len(content))]

    def _dropped_line(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True)
        del lines[self.chance.randrange(len(lines))]
        return b"".join(lines)

    def _swapped_lines(self, content: bytes) -> bytes:
        lines = content.splitlines(keepends=True)
        i, j = self.chance.randrange(len(lines)), self.chance.randrange(len(lines))
        lines[i], lines[j] = lines[j], lines[i]
        return b"".join(lines)


def meaning(session: Session, table: str) -> list[tuple[object, ...]]:
    """Return a table's covered columns as the station reads them."""
    from fixtures_db.schema import Base

    session.expire_all()
    declared = Base.metadata.tables[table]
    columns = [declared.c[name] for name in COLUMNS[table].split()]
    rows = session.execute(declared.select().with_only_columns(*columns).order_by(declared.c.id))
    return [tuple(row) for row in rows]


def mutate(home: Path, times: int, seed: int = 1) -> Counter[str]:
    """Return how many mutations were found, harmless or missed."""
    station, outcome = Station(home, random.Random(seed)), Counter[str]()
    with open_db(home / "station.db") as database:
        kinds: tuple[Callable[[], str], ...] = (lambda: station.in_database(database), station.in_file)
        for i in range(times):
            outcome[kinds[i % 2]()] += 1
    return outcome


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Change ``size`` things, one at a time."""
    with tempfile.TemporaryDirectory() as home:
        outcome = mutate(Path(home), size, seed)
    found, harmless = outcome["found"], outcome["harmless"]
    return {
        "found": Figure(found), "without effect": Figure(harmless), "missed": zero(size - found - harmless),
    }  # fmt: skip
