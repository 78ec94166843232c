"""The demo from the outside, with short dwells."""

import json
from pathlib import Path

import pytest

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.imu_models import Limit, limits_of, set_limits
from station import cli
from station.demo.run import MARK, clear
from station.errors import CannotWrite
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.results.certificate.missing_statements import COMMIT
from tests.patience import paced
from tests.station.commands.program import Program


def test_the_demo_ends_with_a_comparison_and_the_paths_of_its_results(tmp_path: Path) -> None:
    out = tmp_path / "demo"
    short = ("--dwell-s", "3", "--turns", "1", "--speed", f"{paced(100.0):g}")
    with Program("demo", "--out", str(out), *short) as program:
        code, reported, error = program.end()
    assert (code, error) == (0, "")
    assert "samples equal" in reported
    assert "error/u" in reported
    assert "error found that the model lacked: gyroscope.magnetic" in reported
    assert "PASS: SIM-FOG3 SIM-1 is within all 24 limits" in reported
    document = json.loads((out / "calibration.json").read_text())
    assert (document["status"], document["operator"]) == ("calibrated", "station demo")
    if COMMIT.search(document["software"]):
        certificate = (out / "certificate.html").read_text()
        for text in ("DEMO: no laboratory", "simulated device: no hardware was measured", "nothing is traceable"):
            assert text in certificate
    for name in ("report.html", "campaign"):
        assert str(out / name) in reported
    for name in ("report.html", "solution.json", "campaign"):
        assert (out / name).exists()
    assert len(verify_folder(out / "campaign")) == 19 + 18  # moves lead from step to step
    assert "gyroscope.bias.x" in json.loads((out / "truth.json").read_text())
    assert "truth" in (out / "report.html").read_text().lower()
    assert read_campaign(out / "campaign").tables.imu.serial == "SIM-1"


def test_what_a_demo_left_is_cleared_and_nothing_else(tmp_path: Path) -> None:
    clear(tmp_path / "demo")
    for name in ("report.html", "notes.txt"):
        (tmp_path / "demo" / name).write_text("x")
    clear(tmp_path / "demo")
    assert sorted(p.name for p in (tmp_path / "demo").iterdir()) == [MARK, "notes.txt"]
    (tmp_path / "file").write_text("x")
    with pytest.raises(CannotWrite):
        clear(tmp_path / "file")


def test_the_bench_of_a_simulated_unit_is_added_once_and_limits_of_the_user_s_own_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    own = Limit("accelerometer.bias.x", -1.0, 1.0, "g")
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        set_limits(session, "SIM-FOG3", [own])
    for _ in range(2):
        assert cli.run(["fixtures", "example", "7", *db]) == 0
        reported = capsys.readouterr().out
        assert "--cube SIM-CUBE-7 --slab SIM-SLAB-7 --latitude 31.17" in reported
        assert f"--gravity {Truth.example(7).local_gravity:.9g} --gravity-std 1e-05" in reported
    assert cli.run(["fixtures", "show", "cube", "SIM-CUBE-7", *db]) == 0
    assert "simulated: nobody measured it" in capsys.readouterr().out
    assert cli.run(["verify", *db]) == 0
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        assert limits_of(session, "SIM-FOG3") == (own,)
