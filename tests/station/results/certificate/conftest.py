"""A station with one calibration that can be certified, and its command line."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fixtures_db.database import Database
from station import cli
from tests.empty_database import empty_db
from tests.station.results.certificate.factory import EXAMPLE, accepted

ORDER = ("--customer", "Sky AG", "--customer-address", "Town", "--received", "2026-03-02", "--condition", "good")
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def db(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "station.db") as opened:
        with opened.write() as session:
            accepted(session)
        yield opened


@pytest.fixture
def station(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        code = cli.run([*arguments, "--db", str(tmp_path / "station.db")])
        captured = capsys.readouterr()
        assert captured.err.count("\n") <= 1
        return code, captured.out, captured.err

    return run


def certify(station: Run, *more: str) -> tuple[int, str, str]:
    return station("certificate", "S0101", "--laboratory", str(EXAMPLE), *ORDER, *more)
