"""A simulated unit stands at one place, whose gravity it feels, and the program says which."""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth, paper_truth, truth_from
from procedures.campaign.campaign import Campaign
from procedures.geodesy import normal_gravity
from procedures.units import STANDARD_GRAVITY
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.patience import paced
from tests.station.campaign_writing import write_campaign
from tests.station.commands.program import Program


def test_a_unit_feels_the_normal_gravity_of_its_site_unless_it_is_given() -> None:
    away = truth_from({"latitude_deg": 60.0, "height_m": 1000.0}, Truth.example(7))
    assert away.local_gravity == normal_gravity(float(np.radians(60.0)), 1000.0)
    assert truth_from({"gravity_m_s2": 9.81}, away).local_gravity == 9.81
    assert paper_truth().local_gravity == STANDARD_GRAVITY  # the paper's unit of gravity
    site = simulate_campaign(away, 1, dwell_s=1.0, positions=(1,), turns=()).site
    assert site.gravity == away.local_gravity


@pytest.mark.proof
def test_the_recipe_without_hardware_finds_the_truth_within_its_own_sigma(tmp_path: Path) -> None:
    """As the README has it, letter by letter but for time: 60 times as fast, shorter dwells and turns."""
    truth = Truth.example(7)
    faster = ("--speed", f"{paced(60.0):g}")
    shorter = ("--dwell-s", "4", "--turns", "1", "--move-s", "5", "--no-warm-up")
    where = ("--out", str(tmp_path / "c"), "--db", str(tmp_path / "s.db"))
    with Program("simulate", "--example", "7", "--pty", str(tmp_path / "imu"), *faster) as served:
        reported = "".join(served.until("control "))
        url, hands = re.findall(r"^(?:url|control) (\S+)$", reported, re.MULTILINE)
        assert re.search(rf"^site --latitude 31.17 --gravity {truth.local_gravity:.6f}$", reported, re.MULTILINE)
        recipe = ("--device", url, "--latitude", "31.17", "--hands", hands, "--headless")
        with Program("calibrate", *recipe, *shorter, *where) as program:
            code, _, error = program.end()
    assert (code, error) == (0, "")
    found = json.loads((tmp_path / "c" / "solution.json").read_text())
    for triad, k in (("accelerometer", truth.accel_k), ("gyroscope", truth.gyro_k)):
        scale = found[triad]["scale_factor"]
        assert np.max(np.abs(np.array(scale["value"]) - k) / scale["std"]) < 4
    assert not [text for text in found["warnings"] if "gravity" in text]


@cache
def on_the_bench() -> Campaign:
    """Simulate a campaign, once: a stated gravity changes none of its counts."""
    return simulate_campaign(replace(Truth.example(3), sample_period_s=0.05), 3, dwell_s=5.0, turns=())


@pytest.mark.parametrize(
    ("stated", "is_warned"), [(9.80665, True), (9.7943, False), (9.7900, False), (9.7880, True)]
)
def test_a_gravity_that_is_not_that_of_latitude_and_height_is_warned_of_and_solved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], stated: float, is_warned: bool
) -> None:
    campaign = on_the_bench()
    write_campaign(tmp_path / "c", replace(campaign, site=replace(campaign.site, gravity=stated)), 0.05)
    assert cli.run(["solve", str(tmp_path / "c")]) == 0
    warnings = [text for text in read_campaign(tmp_path / "c").warnings if "gravity" in text]
    assert len(warnings) == is_warned
    assert ("gravity_m_s2" in capsys.readouterr().out) == is_warned
    if stated == STANDARD_GRAVITY:
        assert "9.7942" in warnings[0]  # the normal gravity of 31.17 deg
