"""A plan with free positions and a soak as a whole program over a pty."""

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, FreePosition, Soak, Step
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.plan_file import write_plan
from station.files.sha256sums import verify_folder
from tests.patience import paced
from tests.station.commands.program import Program

SPEED = 100.0
FREE = (FreePosition(1, 10.0), FreePosition(2, 10.0))


def calibrate(device: SimulatedDevice, folder: Path, steps: Sequence[Step]) -> tuple[str, ...]:
    write_plan(folder / "plan.toml", steps)
    site = (
        "--latitude",
        "31.17",
        "--gravity",
        f"{device.truth.local_gravity:.7f}",
        "--plan",
        str(folder / "plan.toml"),
    )
    where = ("--out", str(folder / "c"), "--db", str(folder / "s.db"), "--move-s", "5")
    return ("calibrate", "--headless", "--device", device.url, "--hands", device.control, *site, *where)


def test_a_plan_of_free_positions_and_a_soak_becomes_a_folder_that_solves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dwells = tuple(Dwell(position, 10.0) for position in (1, 3, 5, 7, 9, 11))  # each face once
    truth = replace(Truth.example(5), sample_period_s=0.05)
    with SimulatedDevice(truth, 5, speed=paced(SPEED)) as device:
        with Program(*calibrate(device, tmp_path, (*dwells, *FREE, Soak(1, 40.0, 9)))) as program:
            code, reported, error = program.end()
    assert (code, error) == (0, "")
    assert re.findall("^accepted: (free position .|soak .)", reported, re.MULTILINE) == [
        "free position 1", "free position 2", "soak 1",
    ]  # fmt: skip
    assert re.search(r"soak 1: 25 s accepted, [0-9.]+ degC \([0-9.]+ to [0-9.]+ so far\), \d+ s left", reported)
    loaded = read_campaign(tmp_path / "c")
    assert len(loaded.campaign.rests) == 2
    [soak] = [step for step in loaded.steps if step.kind == "soak"]
    assert np.ptp(soak.data.series.temperature) > 5
    assert {"free_01.mcap", "free_02.mcap", "soak_01.mcap"} <= set(verify_folder(tmp_path / "c"))
    assert cli.run(["solve", str(tmp_path / "c"), "--json", str(tmp_path / "s.json")]) == 0
    found = json.loads((tmp_path / "s.json").read_text())["accelerometer"]["scale_factor"]
    off = (np.array(found["value"]) - truth.accel_k) / found["std"]
    assert np.abs(off).max() < 5
    capsys.readouterr()
