"""`station fixtures measure`: a cube measured by the units that were calibrated in it."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.fixture_measurements import measurement, measurements
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import CubeRow
from procedures.campaign.campaign import Fixture
from procedures.positions import face_of
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.guide.campaign.campaign_tables import cube_fixture
from tests.procedures.measured_units import values
from tests.station.campaign_writing import write_campaign

K2 = {"accelerometer.quadratic": {"x": 4e-5, "y": -3e-5, "z": 6e-5}}
TRUTH = replace(Truth.example(3), effects=K2)
AXES = {"day1": ("+x", "+y", "+z"), "day2": ("+y", "-x", "+z"), "day3": ("+x", "+z", "-y")}


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three campaigns of one unit in three mountings, each of 12 dwells of 5 s, and one in a cube that bent."""
    home = tmp_path_factory.mktemp("campaigns")
    bent = TRUTH.faces_rad.copy()
    bent[0, 0] += 2e-5
    cases = {name: replace(TRUTH, imu_axes=axes) for name, axes in AXES.items()}
    cases["bent"] = replace(TRUTH, faces_rad=bent)
    for seed, (name, truth) in enumerate(cases.items()):
        campaign = simulate_campaign(truth, seed, dwell_s=5.0, turns=())
        write_campaign(home / name, replace(campaign, fixture=replace(campaign.fixture, id="CUBE-7")), 0.02)
    return home


@pytest.fixture
def station(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> "Station":
    run = Station(tmp_path / "s.db", capsys)
    assert run("add", "cube", "CUBE-7", "--side-mm", "400")[0] == 0
    return run


class Station:
    """``station fixtures`` on one database."""

    def __init__(self, db: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.db, self.capsys = db, capsys

    def __call__(self, *arguments: str) -> tuple[int, str]:
        code = cli.run(["fixtures", *arguments, "--db", str(self.db)])
        captured = self.capsys.readouterr()
        return code, captured.out + captured.err

    def measure(self, folders: Path, *names: str, more: tuple[str, ...] = ()) -> str:
        code, reported = self("measure", "CUBE-7", *(str(folders / name) for name in names), *more)
        assert code == 0, reported
        return reported


@pytest.fixture(scope="module")
def measured(folders: Path) -> Path:
    """A database that holds the cube as the three mountings show it; next to it the JSON."""
    db = folders / "measured.db"
    days = [str(folders / name) for name in AXES]
    given = ("--store", "--on", "2025-05-01", "--due", "2125-05-01", "--json", str(folders / "cube.json"))
    assert cli.run(["fixtures", "add", "cube", "CUBE-7", "--side-mm", "400", "--db", str(db)]) == 0
    assert cli.run(["fixtures", "measure", "CUBE-7", *days, *given, "--db", str(db)]) == 0
    return db


def test_three_mountings_give_the_cube_within_its_sigma(measured: Path) -> None:
    found = json.loads((measured.parent / "cube.json").read_text())
    assert found["format"] == "measured-cube/1"
    true = values(TRUTH.faces_rad)
    assert set(found["values_rad"]) == set(true)
    for name, value in found["values_rad"].items():
        assert abs(value - true[name]) < 4.5 * found["std_rad"][name]
        assert found["std_rad"][name] < 4e-6
    (unit,) = found["units"]
    assert unit["unit"] == "SIM-FOG3 SIM-3"
    assert set(unit["campaigns"]) == set(AXES)
    assert "drift" not in found


def test_one_mounting_says_what_is_open_and_what_would_close_it(station: Station, folders: Path) -> None:
    reported = station.measure(folders, "day1")
    assert "not observable: skew" in reported
    assert "by 90 deg about x or y" in reported
    assert "SIM-3" not in station("show", "cube", "CUBE-7")[1]  # nothing was stored


def test_a_cube_that_bent_is_seen_and_one_that_did_not_is_not(station: Station, folders: Path) -> None:
    station.measure(folders, "day1", more=("--store", "--on", "2025-05-01"))
    same = simulate_campaign(TRUTH, 77, dwell_s=5.0, turns=())
    write_campaign(station.db.parent / "same", replace(same, fixture=replace(same.fixture, id="CUBE-7")), 0.02)
    reported = station.measure(station.db.parent, "same", more=("--store", "--on", "2025-08-01"))
    assert "has changed" not in reported
    bent = station.measure(folders, "bent", more=("--store", "--on", "2025-09-01"))
    assert "has changed" in bent
    assert "parallelism.x.y" in bent
    shown = station("show", "cube", "CUBE-7")[1]
    assert "3 measurements, 2025-05-01 to 2025-09-01" in shown
    assert "has changed" in shown


def test_a_certificate_of_the_faces_is_compared_and_wins_as_prior(
    measured: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    station = Station(Path(shutil.copy(measured, tmp_path)), capsys)
    with open_db(station.db) as database:
        fixture, table = cube_fixture(database, "CUBE-7")
    assert fixture.measured is not None
    assert table.measured is not None
    assert table.measured.names == list(fixture.measured.names)
    for i, face in enumerate(("x_up", "x_down", "y_up", "y_down", "z_up", "z_down")):
        tilt = [f"{v:.4f}" for v in np.degrees(TRUTH.faces_rad[i]) * 3600]
        by = ("--sigma-arcsec", "0.2", "0.2", "--on", "2025-04-01", "--by", "CMM")
        assert station("add", "certificate", "CUBE-7", face, "--tilt-arcsec", *tilt, *by)[0] == 0
    with open_db(station.db) as database:
        fixture, table = cube_fixture(database, "CUBE-7")
    assert fixture.measured is None
    assert table.measured is None
    assert len(fixture.faces) == 6
    assert "chi-square" in station("show", "cube", "CUBE-7")[1]


def test_a_campaign_written_with_the_measured_cube_reads_and_warns_of_its_own_unit(
    measured: Path, folders: Path, tmp_path: Path
) -> None:
    with open_db(measured) as database:
        fixture, _ = cube_fixture(database, "CUBE-7")
    campaign = read_campaign(folders / "day1").campaign
    write_campaign(tmp_path / "own", replace(campaign, fixture=fixture), 0.02)
    own = read_campaign(tmp_path / "own")
    assert own.campaign.fixture.measured is not None
    assert fixture.measured is not None
    np.testing.assert_array_equal(own.campaign.fixture.measured.covariance, fixture.measured.covariance)
    assert any("SIM-FOG3 SIM-3" in warning for warning in own.warnings)
    write_campaign(tmp_path / "other", replace(campaign, serial="SIM-4", fixture=fixture), 0.02)
    assert not read_campaign(tmp_path / "other").warnings
    assert Fixture().measured is None


def test_what_does_not_belong_is_refused_in_one_line(station: Station, folders: Path) -> None:
    assert station("measure", "CUBE-8", str(folders / "day1"))[0] == 3
    station("add", "cube", "CUBE-8", "--side-mm", "400")
    code, reported = station("measure", "CUBE-8", str(folders / "day1"))
    assert (code, "CUBE-7" in reported) == (3, True)
    code, reported = station("measure", "CUBE-7", str(folders / "day1"), str(folders / "day1"))
    assert code == 3
    assert station("measure", "CUBE-7", str(folders / "day1"), "--due", "2027-01-01")[0] == 2


def test_what_the_dwells_do_not_determine_is_named_and_not_stored(
    station: Station, folders: Path, tmp_path: Path
) -> None:
    whole = read_campaign(folders / "day1").campaign
    some = [dwell for dwell in whole.dwells if face_of(dwell.position) != "x_down"]
    write_campaign(tmp_path / "part", replace(whole, dwells=tuple(some)), 0.02)
    reported = station.measure(tmp_path, "part", more=("--store", "--on", "2025-05-01"))
    assert "not observable: parallelism.x.y" in reported
    with open_db(station.db) as database, database.read() as session:
        (row,) = measurements(fixture_row(session, CubeRow, "CUBE-7"))
        found = measurement(row).cube
    assert "parallelism.x.y" not in found.names
    assert np.sqrt(np.diag(found.covariance)).max() < 1e-3


def test_the_same_campaigns_are_refused_and_those_that_overlap_are_no_drift(
    station: Station, folders: Path
) -> None:
    station.measure(folders, "day1", more=("--store", "--on", "2025-05-01"))
    code, reported = station("measure", "CUBE-7", str(folders / "day1"), "--store", "--on", "2025-06-01")
    assert (code, "2025-05-01" in reported) == (3, True)
    assert "drift over" not in station.measure(folders, "day1")
    reported = station.measure(folders, "day1", "day2", more=("--store", "--on", "2025-06-01"))
    assert "not independent" in reported
    assert "drift over" not in reported
    assert "not independent" in station("show", "cube", "CUBE-7")[1]
