"""What a plan is made of: limits with known values, the hands' times, noise of earlier campaigns."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.campaigns import imu
from fixtures_db.database import Database, open_db
from fixtures_db.imu_models import Limit
from fixtures_db.schema import CampaignRow, StepRow
from procedures.campaign.plan_steps import dwell_steps, turn_steps
from procedures.planning.campaign_design import HandTimes
from procedures.planning.design_sigmas import NAMES
from procedures.planning.step_information import UnitNoise
from station.errors import DataRefused
from station.files.campaign_folder.plan_file import write_plan
from station.results.plan_document import noise_table
from station.results.plan_inputs import hand_times, known_noise, wanted_by, wanted_by_name
from tests.refusals import refused

BIAS = "gyroscope.bias.x"


@pytest.mark.parametrize(
    ("limit", "values", "sigma"),
    [
        (Limit(BIAS, -0.8, 0.8, "deg/h"), {}, 0.1),
        (Limit(BIAS, -0.8, 0.8, "deg/h", 2.0), {BIAS: 0.7}, 0.05),
        (Limit(BIAS, -0.8, 0.8, "deg/h", 2.0), {BIAS: 0.1}, 0.1),
        (Limit(BIAS, None, 0.8, "deg/h", 2.0), {BIAS: 0.7}, 0.05),
        (Limit(BIAS, None, 0.8, "deg/h", 2.0), {}, np.inf),
        (Limit("gyroscope.scale_factor.x", 35000, 37000, "count/deg"), {}, 125 / 36000),
    ],
)
def test_a_limit_asks_for_what_its_guard_band_leaves(limit: Limit, values: dict[str, float], sigma: float) -> None:
    found, reported = wanted_by([limit], values)
    assert found.sigma[NAMES.index(limit.parameter)] == pytest.approx(sigma)
    assert reported == []


def test_a_value_outside_its_limits_is_reported_and_asks_for_nothing() -> None:
    found, reported = wanted_by([Limit(BIAS, -0.8, 0.8, "deg/h", 2.0)], {BIAS: 0.9})
    assert np.all(np.isinf(found.sigma))
    assert reported == ["gyroscope.bias.x was 0.9 deg/h at last, outside its limits: no plan helps"]


def test_sigmas_are_asked_for_in_the_units_of_the_screens() -> None:
    asked = ["accelerometer.bias=0.1ug", "gyroscope.scale_factor.y=2 ppm", "gyroscope.misalignment.xy=1e0arcsec"]
    found = dict(zip(NAMES, wanted_by_name(asked).sigma, strict=True))
    assert [found[f"accelerometer.bias.{axis}"] for axis in "xyz"] == pytest.approx([1e-7] * 3)
    assert found["gyroscope.scale_factor.y"] == pytest.approx(2e-6)
    assert found["gyroscope.misalignment.xy"] == pytest.approx(np.pi / 180 / 3600)
    assert np.isfinite(list(found.values())).sum() == 5


def recorded(database: Database, folder: Path, placement: float, turn: float) -> None:
    folder.mkdir()
    steps = (*dwell_steps(100.0), *turn_steps())
    write_plan(folder / "plan.toml", steps)
    now = datetime(2026, 5, 11, 8, tzinfo=UTC)
    with database.write() as session:
        row = CampaignRow(
            folder=str(folder), imu=imu(session, "FOG-3", "1"), started_utc=now, state="recorded",
            manifest_sha256="0" * 64,
        )  # fmt: skip
        for i, step in enumerate(steps):
            now += timedelta(seconds=100.0 + placement if i < 12 else turn)
            row.steps.append(StepRow(name=step.name, file=f"{step.name}.csv", sha256="0" * 64, accepted_utc=now))
        session.add(row)


def test_the_hands_times_are_those_of_this_stations_campaigns(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        assert hand_times(database)[0] == HandTimes()
        recorded(database, tmp_path / "quick", 2.0, 3.0)  # simulated: no hands were there
        assert hand_times(database)[0] == HandTimes()
        recorded(database, tmp_path / "campaign", 30.0, 50.0)
        found, reported = hand_times(database)
    assert (found.placing, found.turn) == (pytest.approx(30.0), pytest.approx(50.0))
    assert found.move < found.placing
    assert reported.startswith("30 s per placement, the median of 11")


def test_a_unit_whose_campaigns_are_gone_has_no_known_noise(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        recorded(database, tmp_path / "campaign", 30.0, 50.0)  # no recordings in it
        with refused(DataRefused, None, "--noise"):
            known_noise(database, "FOG-3", "1", [])


def test_noise_is_by_axis_in_deg_per_root_hour_and_the_bias_instability_in_deg_per_hour() -> None:
    noise = UnitNoise(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0]), np.ones(3), np.ones(3), 2e-6)
    found = noise_table(noise)
    assert found["accelerometer_g_sqrt_s"] == {"x": 1.0, "y": 2.0, "z": 3.0}
    assert found["gyroscope_deg_sqrt_h"]["y"] == pytest.approx(120.0)  # deg/sqrt(s), 60 sqrt(s) in a sqrt(h)
    assert found["wander_deg_h"] == pytest.approx(7.2e-3)
