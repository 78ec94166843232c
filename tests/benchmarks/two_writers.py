"""Two processes write to one database at once: `python -m tests.benchmarks.two_writers [--transactions 10000]`.

Each transaction accepts a calibration and appends a slab level: two chains that must not be crossed. SQLite, and
the PostgreSQL of STATION_TEST_POSTGRES: `python -m tests.with_postgres python -m tests.benchmarks.two_writers`.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from fixtures_db import database
from fixtures_db.database import open_db
from fixtures_db.fixtures import add_fixture, fixture_row
from fixtures_db.hash_chain import ChainFault
from fixtures_db.hash_chain_verification import alterations
from fixtures_db.schema import SlabRow
from fixtures_db.slab_levels import add_level
from fixtures_db.stored_calibrations import accept_calibration, history
from tests.fixtures_db.factory import NOON, facts, level_row, solution
from tests.paths import ROOT
from tests.patience import HANG_S
from tests.with_postgres import URL

WRITERS = ("A", "B")


def write(url: str, name: str, transactions: int) -> None:
    """Write as one of the two does; it waits for the lock however long the other one, or the machine, takes."""
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
    command = [sys.executable, "-m", "tests.benchmarks.two_writers", "--transactions", str(transactions)]
    root = ROOT
    writers = [subprocess.Popen([*command, "--write", url, name], cwd=root) for name in WRITERS]
    codes = [writer.wait() for writer in writers]
    if any(codes):
        raise SystemExit("a writer failed")
    with open_db(url) as opened, opened.read() as session:
        there = sum(
            len(history(session, name)) + len(fixture_row(session, SlabRow, name).levels) for name in WRITERS
        )
        return 2 * len(WRITERS) * transactions - there, alterations(session)


def urls(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the databases that there are."""
    yield "SQLite", f"sqlite:///{folder / 'station.db'}"
    if server := os.environ.get(URL):
        yield "PostgreSQL", server


def main() -> None:
    """Print a line for each database."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--transactions", type=int, default=500)
    parser.add_argument("--write", nargs=2, metavar=("URL", "NAME"))
    options = parser.parse_args()
    if options.write:
        write(*options.write, options.transactions)
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, url in urls(Path(folder)):
            began = time.perf_counter()
            lost, faults = both(url, options.transactions)
            each = 2 * options.transactions / (time.perf_counter() - began)
            print(
                f"{name:<10} 2 x {options.transactions} transactions, {each:5.0f}/s: {lost} rows lost, "
                f"{len(faults)} crossed chains   asked 0, 0"
            )


if __name__ == "__main__":
    main()
