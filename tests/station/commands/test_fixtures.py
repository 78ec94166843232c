"""`station fixtures`: added, listed, written out, taken in again; what would change a stored row is refused."""

from pathlib import Path

import pytest

from fixtures_db.database import open_db
from fixtures_db.fixture_transfer import dump
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


MEASURED = ("--tilt-arcsec", "1.5", "-0.5", "--sigma-arcsec", "0.5", "0.25", "--by", "CMM 12")


def test_what_is_added_is_listed_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    add = Station(tmp_path / "s.db", capsys)
    items = ("--tolerance", "t1=0.04", "--tolerance", "t8=0.02")
    assert add("fixtures", "add", "cube", "C7", "--side-mm", "400", *items) == (0, "cube C7: added\n")
    face = ("certificate", "C7", "x_up", *MEASURED, "--on", "2026-03-04", "--due", "2999-03-04")
    assert add("fixtures", "add", *face)[0] == 0
    assert add("fixtures", "add", "slab", "S1")[0] == 0
    for day in ("2026-03-04", "2026-02-04"):
        assert add("fixtures", "add", "level", "S1", *MEASURED, "--on", day, "--due", day)[0] == 0
    gravity = (
        "--gravity",
        "9.8072914",
        "--gravity-sigma",
        "2e-7",
        "--gravity-by",
        "survey 12",
        "--due",
        "2020-01-01",
    )
    assert add("fixtures", "add", "site", "L1", "--latitude", "48.1", *gravity)[0] == 0
    assert add("fixtures", "add", "imu", "FOG-3", "0117")[0] == 0
    assert add("fixtures", "list")[1].splitlines() == [
        "cube C7: 400 mm, 1 of 6 faces certified, due 2999-03-04",
        "cube P1: 400 mm, 0 of 6 faces certified, no due date",
        "slab S1: east +1.50 +- 0.50, north -0.50 +- 0.25 arcsec (CMM 12, 2026-03-04), expired on 2026-03-04",
        "site L1: latitude 48.100000 deg, gravity 9.8072914 +- 2e-07 m/s2, expired on 2020-01-01",
        "imu FOG-3 0117: no calibration",
    ]
    assert (
        "x_up: up tilt +1.50 +- 0.50, -0.50 +- 0.25 arcsec (CMM 12, 2026-03-04)"
        in add("fixtures", "show", "cube", "C7")[1]
    )
    assert add("fixtures", "show", "slab", "S1")[1].count("CMM 12") == 2
    assert "survey 12" in add("fixtures", "show", "site", "L1")[1]
    assert add("fixtures", "show", "imu", "0117")[1] == "FOG-3 0117: no calibration\n"
    assert add("fixtures", "due")[1].splitlines() == [
        "site L1: expired on 2020-01-01", "slab S1: expired on 2026-03-04"
    ]  # fmt: skip
    assert "cube C7: in " in add("fixtures", "due", "--within", "999999")[1]


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("show", "cube", "C9"), 3, "no cube 'C9' in the database (it has CUBE-7, P1)"),
        (("show", "imu", "S9"), 3, "it has S1, S2"),
        (("add", "cube", "P1", "--side-mm", "400"), 3, "in the database already"),
        (("add", "cube", "P2", "--side-mm", "-1"), 2, "expected a positive length"),
        (("add", "cube", "P2", "--side-mm", "400", "--tolerance", "t1"), 2, "such as t1=0.04"),
        (("add", "cube", "P2", "--side-mm", "400", "--tolerance", "t99=1"), 2, "none of t1"),
        (("add", "certificate", "P1", "top", *MEASURED, "--on", "2026-03-04"), 2, "none of x_up"),
        (("add", "level", "S9", *MEASURED, "--on", "2026-03-04"), 3, "it has SLAB-1"),
        (("add", "site", "L1", "--latitude", "48", "--gravity", "9.8"), 2, "expected --gravity-sigma"),
        (("add", "site", "L1", "--latitude", "98"), 2, "within 90 deg"),
        (("add", "imu", "FOG-3", "S1"), 3, "in the database already"),
        (("due", "--within", "-1"), 2, "within"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    filled: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], code: int, said: str
) -> None:
    before = rows(filled)
    found, text = Station(filled, capsys)("fixtures", *arguments)
    assert (found, said in text) == (code, True), text
    assert rows(filled) == before


@pytest.mark.parametrize("name", ["out.toml", "out"])
def test_an_export_taken_into_an_empty_database_is_equal(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    out = str(tmp_path / name)
    assert Station(filled, capsys)("fixtures", "export", out)[0] == 0
    other = Station(tmp_path / "b.db", capsys)
    assert other("fixtures", "import", out)[1].endswith(
        "added 1 cube, 2 tolerance, 3 certificate, 2 measurement, 1 slab, 2 level, 1 site, 2 imu\n"
    )
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


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.toml", 'format = "fixtures/2"\n', "a.toml:1: found format 'fixtures/2', expected fixtures/1"),
        ("a.toml", '[[slab]]\nid = "S"\nweight = 3\n', "a.toml:3: found unknown key"),
        ("a.toml", '[[site]]\nid = "S"\nlatitude_deg = 91.0\n', "expected within 90 deg"),
        ("a.toml", '[[cube]]\nid = "P1"\nside_mm = 300.0\n', "expected 400.0 as in the database"),
        (
            "a.toml",
            '[[tolerance]]\ncube_id = "X"\nitem = "t1"\nkind = "flatness"\nface = "A"\ntolerance_mm = 1\n',
            "no cube 'X'",
        ),
        ("slab.csv", "id,due_date\nS9,tomorrow\n", "slab.csv:2: found due_date 'tomorrow'"),
        ("slabs.csv", "id\nS9\n", "one of cube.csv"),
        ("slab.csv", 'id\n"S9\n', "slab.csv"),
    ],
)
def test_a_file_that_is_wrong_is_refused_with_its_line(
    filled: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, text: str, said: str
) -> None:
    (tmp_path / name).write_text(text)
    before = rows(filled)
    code, line = Station(filled, capsys)("fixtures", "import", str(tmp_path / name))
    assert (code, said in line) == (3, True), line
    assert rows(filled) == before
