"""Folders with free dwells, faces without heading and sequences, and what others' tools found on the same data."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.calibration.residuals import norm_residuals
from procedures.units import STANDARD_GRAVITY
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.paths import DATA
from tests.station.campaign_writing import write_campaign


@pytest.fixture(scope="module")
def data() -> Path:
    path = DATA
    if not (path / "measured/xsens_mti").is_dir():
        pytest.skip(f"no shared data at {path}: set STATION_DATA")
    return path


@pytest.fixture(scope="module")
def xsens(data: Path) -> CampaignFits:
    return fit([read_campaign(data / "measured/xsens_mti").campaign])


def test_the_norm_of_the_xsens_rests_is_gravity_within_a_thousandth(xsens: CampaignFits) -> None:
    assert xsens.accelerometer is not None
    assert xsens.accelerometer.rests is not None
    longer = norm_residuals(xsens.accelerometer.rests, xsens.accelerometer.fit.residual) * STANDARD_GRAVITY
    assert len(longer) >= 38  # about so many were set by hand
    assert np.sqrt(np.mean(longer**2)) <= 1.00e-3  # m/s2, issue 4


def test_the_xsens_scale_factors_are_those_of_imu_tk(xsens: CampaignFits) -> None:
    assert xsens.accelerometer is not None
    k = np.linalg.norm(xsens.accelerometer.K, axis=1) / STANDARD_GRAVITY
    assert k == pytest.approx([414.5, 412.0, 414.7], rel=1e-3)  # count/(m/s2)


def test_the_xsens_gyroscopes_carry_gravity_better_than_imu_tk(xsens: CampaignFits) -> None:
    assert xsens.moves is not None
    error = np.degrees(np.linalg.norm(xsens.moves.error, axis=1))
    assert len(error) >= 37
    assert np.sqrt(np.mean(error**2)) <= 0.42  # imu_tk has 0.518, with bias 0.467
    k = np.degrees(np.linalg.norm(xsens.moves.K, axis=1))
    assert k == pytest.approx([4778, 4758, 4766], rel=5e-3)  # the maker's, LSB/(rad/s)


def test_a_sequence_alone_makes_a_solution(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    assert cli.run(["solve", str(data / "measured/xsens_mti"), "--json", str(out)]) == 0
    solution = json.loads(out.read_text())
    assert solution["accelerometer"]["scale_factor"]["unit"] == "output/g"
    assert {"slab", "fixture"}.isdisjoint(solution)
    assert solution["unused_steps"] == []
    assert any("rotation of the frame" in name for name in solution["not_observable"])
    assert len(solution["covariance"]["names"]) == 30
    assert solution["residual"]["p_value"] < 0.01  # a MEMS unit by hand: more than noise


def test_six_faces_without_heading_make_an_accelerometer(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.json"
    assert cli.run(["solve", str(data / "measured/imucal_six_faces"), "--json", str(out)]) == 0
    solution = json.loads(out.read_text())
    k = np.array(solution["accelerometer"]["scale_factor"]["value"]) / STANDARD_GRAVITY
    assert k == pytest.approx([1.0, 1.0, 1.0], rel=0.03)  # scaled by its data sheet
    assert (
        "accelerometer.quadratic (with accelerometer.bias and fixture.parallelism)" in solution["not_observable"]
    )


def test_two_faces_are_not_enough(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["solve", str(data / "measured/ln100_two_positions")]) == 5
    assert "2 found" in capsys.readouterr().err


def test_free_dwells_with_a_cube_leave_three_perpendicularities_open_instead_of_six(
    data: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out.json"
    assert cli.run(["solve", str(data / "campaigns/quadratic_free"), "--json", str(out)]) == 0
    solution = json.loads(out.read_text())
    assert sum("perpendicularity" in name for name in solution["not_observable"]) == 3
    assert solution["unused_steps"] == []
    assert solution["residual"]["p_value"] < 0.01  # K2 is planted, and not in the model
    matrix = np.array(solution["covariance"]["matrix"])
    std = np.sqrt(np.diag(matrix))
    assert np.linalg.eigvalsh(matrix / np.outer(std, std)).min() > -1e-9


def test_free_dwells_faces_and_sequences_are_written_as_they_were_read(data: Path, tmp_path: Path) -> None:
    for source in ("campaigns/quadratic_free", "measured/imucal_six_faces", "measured/xsens_mti"):
        loaded = read_campaign(data / source)
        twin = tmp_path / source
        write_campaign(twin, loaded.campaign, loaded.tables.imu.sample_period_s)
        again = read_campaign(twin)
        assert again.tables.steps() == [s.model_copy(update=_start(s)) for s in loaded.tables.steps()]
        for one, other in zip(again.campaign.rests, loaded.campaign.rests, strict=True):
            assert (one.name, one.up) == (other.name, other.up)
            assert np.array_equal(one.series.accel, other.series.accel)


def _start(step: object) -> dict[str, int]:
    axis = getattr(step, "axis", None)
    return {"start_position": {"x": 1, "y": 5, "z": 9}[axis]} if axis else {}
