"""`station fixtures`: written out and taken in again; a file that was changed is refused."""

from pathlib import Path

import pytest

from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import dump
from station import cli
from tests.fixtures_db.factory import fill_fixtures


@pytest.fixture
def filled(tmp_path: Path) -> Path:
    with open_db(tmp_path / "a.db") as database, database.write() as session:
        fill_fixtures(session)
    return tmp_path / "a.db"


class Station:
    """The command line on one database."""

    def __init__(self, db: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.db, self.capsys = db, capsys

    def __call__(self, *arguments: str) -> tuple[int, str]:
        code = cli.run([*arguments, "--db", str(self.db)])
        captured = self.capsys.readouterr()
        assert captured.err.count("\n") <= 1
        return code, captured.out + captured.err


def rows(db: Path) -> object:
    with open_db(db) as database, database.read() as session:
        return dump(session)


@pytest.mark.parametrize("name", ["out.toml", "out"])
def test_an_export_taken_into_an_empty_database_is_equal(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    out = str(tmp_path / name)
    assert Station(filled, capsys)("fixtures", "export", out)[0] == 0
    other = Station(tmp_path / "b.db", capsys)
    assert other("fixtures", "import", out)[0] == 0
    assert rows(tmp_path / "b.db") == rows(filled)
    assert other("fixtures", "import", out)[1].endswith("added nothing\n")
    assert other("verify", out)[0] == 0
    assert other("verify")[0] == 0


def test_a_changed_export_is_neither_verified_nor_taken_in(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, station = tmp_path / "out.toml", Station(filled, capsys)
    station("fixtures", "export", str(out))
    out.write_text(out.read_text().replace("side_mm = 400.0", "side_mm = 300.0", 1))
    assert station("verify", str(out))[0] == 1
    code, text = station("fixtures", "import", str(out))
    assert (code, "sha256" in text) == (1, True)
    station("fixtures", "export", str(tmp_path / "csv"))
    (tmp_path / "csv/slab.csv").write_text("id,certificate_date,due_date\nSLAB-1,,\n")
    assert station("fixtures", "import", str(tmp_path / "csv"))[0] == 1
    assert station("fixtures", "export", str(tmp_path / "csv"))[0] == 2  # not empty
