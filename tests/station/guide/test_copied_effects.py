"""A campaign is recorded with the effects that are in force of its unit: in its folder, listed and hashed."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.own_effects import add_effect
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.setup import Setup
from station.guide.headless import record_headless
from station.guide.simulated_operator import SimulatedOperator
from station.guide.start_engine import EngineOptions
from tests.patience import paced

PLAN = """format = "plan/1"
[[dwell]]
position = 1
seconds = 4
"""
EFFECT = """format = "effect/1"
name = "dead_zone"
triad = "gyroscope"
term = "-u * exp(-(u / w)**4)"
unit = "1"
plausible = 1.0
source = "Lefevre 10.3"
shape.w = {unit = "deg/h", low = 1, high = 100}
"""


def test_the_effects_of_a_unit_are_copied_into_its_campaign_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, folder = tmp_path / "plan.toml", tmp_path / "c"
    plan.write_text(PLAN)
    options = EngineOptions(root=tmp_path, plan=plan, warms_up=False, asks=False).engine()
    truth = Truth.example(5)
    with SimulatedDevice(truth, 5, speed=paced(100.0)) as device, open_db(tmp_path / "s.db") as database:
        with database.write() as session:
            row = add_effect(session, "gyroscope.dead_zone", EFFECT, truth.model, truth.serial)
            add_effect(session, "gyroscope.dead_zone", EFFECT.replace("1.0", "2.0"), truth.model, "of another")
        setup = Setup(url=device.url, latitude_deg=31.17, folder=str(folder), dwell_s=4.0)
        with closing(SimulatedOperator(device.control, 5.0)) as operator:
            record_headless(setup, replace(options, is_patient=False), database, operator, lambda view: None)
    found = read_campaign(folder)
    assert [one.name for one in found.effects] == ["gyroscope.dead_zone"]
    assert found.effects[0].text == EFFECT
    assert found.files["effect_gyroscope_dead_zone.toml"] == row.effect_sha256
    assert found.tables.effects is not None
    assert found.tables.effects.sha256 == [row.effect_sha256]
    verify = ["verify", str(folder), "--db", str(tmp_path / "s.db")]
    assert cli.run(verify) == 0
    (folder / "effect_gyroscope_dead_zone.toml").write_text(EFFECT.replace("1.0", "3.0"))
    assert cli.run(verify) == 1
    assert cli.run(["solve", str(folder)]) == 3
    assert "bring back the file" in capsys.readouterr().err
