"""Two processes write to one database at once, each to two chains that must not cross; SQLite and PostgreSQL."""

import os
import subprocess
import sys
import tempfile

from fixtures_db import database
from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import add_level
from fixtures_db.fixtures import add_fixture, fixture_row
from fixtures_db.hash_chain import ChainFault
from fixtures_db.schema import SlabRow
from fixtures_db.stored_calibrations import accept_calibration, history
from fixtures_db.verification import alterations
from tests.fixtures_db.factory import NOON, facts, level_row, solution
from tests.paths import ROOT
from tests.patience import HANG_S
from tests.proof.evidence import Figure, zero
from tests.with_postgres import URL

WRITERS = ("A", "B")


def write(url: str, name: str, transactions: int) -> None:
    """Write as one of the two does; it waits for the lock however long that takes."""
    database.BUSY_TIMEOUT_S = HANG_S
    with open_db(url) as opened:
        for i in range(transactions):
            with opened.write() as session:
                accept_calibration(session, solution(i * 1e-6), facts(name))
                tilt, std = (i * 1e-9, 0.0), (1e-6, 1e-6)
                add_level(session, level_row(name, tilt, std, source="level", measured_utc=NOON))


def both(url: str, transactions: int) -> tuple[int, list[ChainFault]]:
    """Let two processes write; return how many transactions are lost, and the faults of the chains."""
    with open_db(url) as opened, opened.write() as session:
        for name in WRITERS:
            add_fixture(session, SlabRow(id=name))
    command = [sys.executable, "-m", "tests.benchmarks.two_writers", url]
    writers = [subprocess.Popen([*command, name, str(transactions)], cwd=ROOT) for name in WRITERS]
    codes = [writer.wait() for writer in writers]
    if any(codes):
        raise SystemExit("a writer failed")
    with open_db(url) as opened, opened.read() as session:
        there = sum(
            len(history(session, name)) + len(fixture_row(session, SlabRow, name).levels) for name in WRITERS
        )
        return 2 * len(WRITERS) * transactions - there, alterations(session)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return what ``size`` transactions of each of two processes lost."""
    result = dict[str, Figure]()
    with tempfile.TemporaryDirectory() as folder:
        urls = {"SQLite": f"sqlite:///{folder}/station.db", "PostgreSQL": os.environ.get(URL, "")}
        for name, url in urls.items():
            if url:
                lost, faults = both(url, size)
                result[f"{name}: rows lost"] = zero(lost)
                result[f"{name}: faults of the chains"] = zero(len(faults))
    return result


if __name__ == "__main__":  # one of the two writers
    write(sys.argv[1], sys.argv[2], int(sys.argv[3]))
