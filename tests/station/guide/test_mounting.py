"""A plan that wants the IMU mounted otherwise: the guide sees the faces through it and the folder says so."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.simulated_hands import SimulatedHands
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.setup import Setup
from station.guide.headless import record_headless
from station.guide.simulated_operator import SimulatedOperator
from station.guide.start_engine import EngineOptions
from tests.patience import paced

PLAN = """format = "plan/1"
[fixture]
imu_axes = ["+y", "-x", "+z"]
[[dwell]]
position = 1
seconds = 4
[[dwell]]
position = 7
seconds = 4
"""


def test_a_remounted_imu_is_guided_and_recorded_as_mounted(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    options = replace(
        EngineOptions(root=tmp_path, plan=plan, warms_up=False, asks=False).engine(), is_patient=False
    )
    truth = replace(Truth.example(5), imu_axes=("+y", "-x", "+z"))
    with SimulatedDevice(truth, 5, speed=paced(100.0)) as device, open_db(tmp_path / "s.db") as database:
        setup = Setup(url=device.url, latitude_deg=31.17, folder=str(tmp_path / "c"), dwell_s=4.0)
        with closing(SimulatedOperator(SimulatedHands(device.control), 5.0)) as operator:
            record_headless(setup, options, database, operator, lambda view: None)
    found = read_campaign(tmp_path / "c")
    assert found.tables.fixture.imu_axes == ["+y", "-x", "+z"]
    assert [dwell.position for dwell in found.campaign.dwells] == [1, 7]
