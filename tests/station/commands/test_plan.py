"""`station plan`: its plan has what is asked for, and the sigmas that it states are those of a solve."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.calibration.joint_calibration import solve
from procedures.campaign.plan_steps import Dwell
from station import cli
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.campaign_folder.plan_file import read_plan
from station.guide.campaign.campaign_tables import planned_bench
from station.guide.options import setup_file
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign

SEED, LATITUDE = 7, "31.17"
LIMITS = """model = "SIM-FOG3"
[[limit]]
parameter = "gyroscope.bias"
low = {low}
high = {high}
unit = "deg/h"
guard_band = 2.0
[[limit]]
parameter = "residual.p_value"
low = 0.01
unit = "1"
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded") / "campaign"
    truth = Truth.example(SEED)
    write_campaign(folder, simulate_campaign(truth, SEED, dwell_s=20.0), truth.sample_period_s)
    return folder


@pytest.fixture(autouse=True)
def _own_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATION_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("STATION_DB", str(tmp_path / "station.db"))


def planned(tmp_path: Path, *arguments: str) -> tuple[int, dict]:
    out = tmp_path / "planned.json"
    code = cli.run(["plan", *arguments, "--json", str(out)])
    return code, json.loads(out.read_text())


@pytest.mark.proof
def test_a_simulated_campaign_of_the_plan_has_the_sigmas_that_the_plan_states(
    recorded: Path, tmp_path: Path
) -> None:
    plan = tmp_path / "plan.toml"
    code, document = planned(
        tmp_path, "--sigma", "gyroscope.bias=0.03deg/h", "--sigma", "gyroscope.scale_factor=4ppm",
        "--noise", str(recorded), "--latitude", LATITUDE, "--no-turns", "--out", str(plan),
    )  # fmt: skip
    assert code == 0
    assert document["minutes"] < document["usual_minutes"]
    steps = read_plan(plan)
    assert len(steps) == len(document["steps"])
    dwells = [step for step in steps if isinstance(step, Dwell)]
    assert [step.seconds for step in dwells] == [step["seconds"] for step in document["steps"]]
    seconds = max(step.seconds for step in dwells)
    truth = Truth.example(SEED)
    campaign = simulate_campaign(
        truth, 3, dwell_s=seconds, positions=[step.position for step in dwells], turns=(), moves=True, move_s=25.0
    )
    gyroscope = solve([campaign]).gyroscope
    assert gyroscope is not None
    stated = {row["parameter"]: row["plan"] for row in document["sigmas"]}
    bias, k = gyroscope.bias.std, gyroscope.scale_factor.std / np.abs(gyroscope.scale_factor.value) * 1e6
    assert np.median(bias) == pytest.approx(np.median([stated[f"gyroscope.bias.{a}"] for a in "xyz"]), rel=0.3)
    assert np.median(k) == pytest.approx(
        np.median([stated[f"gyroscope.scale_factor.{a}"] for a in "xyz"]), rel=0.3
    )


def test_limits_of_a_file_are_wanted_to_an_eighth_of_their_half_interval(recorded: Path, tmp_path: Path) -> None:
    limits = tmp_path / "limits.toml"
    limits.write_text(LIMITS.format(low=-0.4, high=0.4))
    code, document = planned(tmp_path, "--limits", str(limits), "--noise", str(recorded), "--latitude", LATITUDE)
    wanted = {row["parameter"]: row["wanted"] for row in document["sigmas"] if "wanted" in row}
    assert wanted == {f"gyroscope.bias.{axis}": pytest.approx(0.05) for axis in "xyz"}
    assert code == 0


def test_what_is_out_of_reach_is_named_and_is_exit_1(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["plan", "--sigma", "gyroscope.bias.x=0.0001deg/h", "--noise", str(recorded), "--latitude", LATITUDE]
    assert cli.run([*asked, "--minutes", "12", "--no-turns"]) == 1
    reported = capsys.readouterr().out
    assert "gyroscope bias x 0.000100 deg/h" in reported
    assert float(reported.split(" min")[0]) <= 12


def test_without_a_site_nothing_is_planned(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not setup_file().exists()
    shutil.copytree(recorded, nowhere := tmp_path / "nowhere")
    text = (recorded / "campaign.toml").read_text()
    begin, end = text.index("[site]"), text.index("[procedure]")
    (nowhere / "campaign.toml").write_text(text[:begin] + text[end:])
    assert cli.run(["plan", "--noise", str(nowhere)]) != 0
    assert capsys.readouterr().err.count("\n") == 1
    with open_db(tmp_path / "s.db") as database:
        with refused(DataRefused):
            planned_bench(database, None, None, [nowhere])
        stated = read_campaign_toml(recorded)[0].site
        assert stated is not None
        found = planned_bench(database, None, None, [nowhere, recorded]).site.latitude
        assert found == pytest.approx(np.radians(stated.latitude_deg))


def test_a_campaign_that_was_begun_is_shown_what_comes_next(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    begun, truth = tmp_path / "begun", Truth.example(SEED)
    few = simulate_campaign(truth, 5, dwell_s=30.0, positions=(1, 3, 6, 8), turns=(), moves=True)
    write_campaign(begun, few, truth.sample_period_s)
    known = ["--noise", str(recorded), "--latitude", LATITUDE]
    asked = ["plan", "--sigma", "gyroscope.bias=0.03deg/h", *known, "--continue"]
    assert cli.run([*asked, str(begun)]) == 0
    first, left, last = capsys.readouterr().out.splitlines()
    assert "0.0300 deg/h" in first
    assert " min " in left
    assert last.split()[1].rstrip(",") not in {"UEN", "DNE", "NUE", "EDN"}
