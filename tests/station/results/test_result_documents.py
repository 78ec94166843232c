"""solution/1 and budget/1 as docs/reference/file-formats.md has them, and as people read them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit
from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration
from procedures.campaign.campaign import Campaign, Site
from procedures.uncertainty.budget import budget
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.model_refinement import budget_document
from station.results.result_formats import document_of
from station.results.solution_json import solution_document
from station.results.solution_text import measured


def estimate(unit: str, *shape: int) -> Estimate:
    return Estimate(np.ones(shape), np.full(shape, 0.01), unit)


def triad(scale: str, bias: str) -> TriadCalibration:
    return TriadCalibration(
        estimate(scale, 3), estimate("1", 3, 3), estimate(bias, 3), estimate(bias, 3), estimate(bias, 3)
    )


SOLUTION = Solution(
    triad("count/(g s)", "g"),
    triad("count/deg", "deg/h"),
    estimate("rad", 2),
    estimate("rad", 3, 2),
    FitQuality(30.0, 28, 0.36, 1e-7, 0.01),
    ("a", "b"),
    np.eye(2),
    23.0,
    not_observable=("perpendicularity xy",),
    warnings=("from the solve",),
)


def loaded(folder: str, serial: str = "S1") -> LoadedCampaign:
    tables = CampaignTable.model_validate(
        {
            "format": "campaign/1",
            "imu": {"model": "FOG-3", "serial": serial, "sample_period_s": 0.02, "output": "increments"},
            "site": {"latitude_deg": 1},
        }
    )
    campaign = Campaign("FOG-3", serial, True, Site(0.0, 9.8, 1e-5), (), ())
    files = {"campaign.toml": "0" * 64}
    return LoadedCampaign(Path(folder), tables, campaign, (), files, ("from the folder",), ("rate (r.csv)",))


def document(solution: Solution = SOLUTION, *folders: str) -> dict[str, Any]:
    campaigns = [loaded(folder) for folder in folders or ("a",)]
    found: dict[str, Any] = document_of(solution_document(solution, campaigns))
    return found


def test_all_parts_stand_under_their_names() -> None:
    got = document()
    assert list(got) == [
        "format", "accelerometer", "gyroscope", "slab", "fixture", "residual", "covariance",
        "reference_temperature_c", "not_observable", "warnings", "unused_steps", "provenance",
    ]  # fmt: skip
    assert got["format"] == "solution/1"
    assert list(got["accelerometer"]) == [
        "scale_factor", "misalignment", "bias_12_position", "bias_two_direction", "bias",
    ]  # fmt: skip
    assert got["accelerometer"]["bias"] == {
        "value": [1.0] * 3, "std": [0.01] * 3, "unit": "g", "estimator": "joint",
    }  # fmt: skip
    assert got["slab"]["tilt_rad"]["value"] == [1.0, 1.0]
    assert np.shape(got["fixture"]["parallelism_rad"]["std"]) == (3, 2)
    assert got["residual"] == {
        "accelerometer_rms_g": 1e-7, "gyroscope_rms_deg_h": 0.01, "chi2": 30.0, "dof": 28, "p_value": 0.36,
    }  # fmt: skip
    assert got["covariance"] == {"names": ["a", "b"], "matrix": [[1.0, 0.0], [0.0, 1.0]]}
    assert got["warnings"] == ["from the folder", "from the solve"]
    assert got["unused_steps"] == ["rate (r.csv)"]
    assert got["provenance"]["files"] == {"campaign.toml": "0" * 64}
    assert got["provenance"]["software"].startswith("fog-station ")
    assert got["provenance"]["created_utc"].endswith("Z")


def test_what_is_not_estimated_is_left_out() -> None:
    bare = replace(
        SOLUTION,
        gyroscope=None,
        slab_tilt=None,
        parallelism=None,
        quality=FitQuality(0.0, 0, float("nan")),
        reference_temperature=None,
    )
    got = document(bare)
    assert not {"gyroscope", "slab", "fixture", "reference_temperature_c"} & set(got)
    assert got["residual"] == {"chi2": 0.0, "dof": 0}


def test_what_is_not_finite_is_left_out_and_reported() -> None:
    wild = Estimate(np.array([1.0, np.nan]), np.array([np.inf, 1.0]), "rad")
    got = document(replace(SOLUTION, slab_tilt=wild, covariance=np.full((2, 2), np.inf)))
    assert not {"slab", "covariance"} & set(got)
    assert "slab.tilt_rad is not finite and was omitted" in got["warnings"]
    json.dumps(got, allow_nan=False)


def test_files_of_several_campaigns_keep_apart() -> None:
    assert set(document(SOLUTION, "x/a", "x/b")["provenance"]["files"]) == {"a/campaign.toml", "b/campaign.toml"}
    assert len(document(SOLUTION, "x/a", "y/a")["provenance"]["files"]) == 2


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1020.123456, 0.0023, "1020.1235 +- 0.0023 g"),
        (-0.00100012, 8e-8, "-1.000120e-03 +- 8.0e-08 g"),
        (123.4, 250.0, "123 +- 250 g"),
        (1.00100004, 1.2e-7, "1.00100004 +- 0.00000012 g"),
        (0.998, 3e-13, "9.9800000000000e-01 +- 3.0e-13 g"),
        (0.0, 1e-9, "0.0e+00 +- 1.0e-09 g"),
        (1.5, 0.0, "1.5 g"),
    ],
)
def test_a_value_is_shown_to_two_digits_of_its_sigma(value: float, std: float, text: str) -> None:
    assert measured(value, std, "g") == text


def test_budget_1_holds_every_parameter_and_its_contributions_and_no_infinity() -> None:
    budgets = budget(fit([simulate_campaign(Truth.example(2), 2, dwell_s=10.0)]))
    document = json.loads(json.dumps(budget_document(budgets), allow_nan=False))
    assert (document["format"], document["coverage"]) == ("budget/1", 0.95)
    assert len(document["parameters"]) == 24
    for one in document["parameters"]:
        assert one["std"] ** 2 == pytest.approx(sum(part["std"] ** 2 for part in one["contributions"]))
        assert one["expanded"] == pytest.approx(one["coverage_factor"] * one["std"])
        assert all(part["std"] > 0 for part in one["contributions"])
        assert {part["type"] for part in one["contributions"]} <= {"A", "B"}
    (gravity,) = [p for p in document["parameters"][0]["contributions"] if p["source"] == "gravity"]
    assert "dof" not in gravity
    assert gravity["std"] == pytest.approx(document["parameters"][0]["value"] * 1e-5 / 9.80665, rel=1e-2)


def test_a_parameter_that_is_not_finite_is_left_out() -> None:
    budgets = budget(fit([simulate_campaign(Truth.example(2), 2, dwell_s=10.0)]))
    broken = [replace(budgets[0], std=float(np.nan)), *budgets[1:]]
    assert len(budget_document(broken)["parameters"]) == 23
