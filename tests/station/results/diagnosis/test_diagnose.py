"""``station diagnose`` as a whole program: what it writes, what it says, and with which exit code it ends."""

import json
import math
import shutil
from pathlib import Path
from typing import Any

import pytest

from station import cli
from station.results.diagnosis.diagnosis_text import diagnosis_text
from tests.paths import DATA
from tests.station.results.diagnosis.conftest import Diagnosed, simulated


def numbers(node: Any) -> list[float]:
    if isinstance(node, dict):
        return [n for value in node.values() for n in numbers(value)]
    if isinstance(node, list):
        return [n for value in node for n in numbers(value)]
    return [node] if isinstance(node, float) else []


def finding(found: Diagnosed, effect: str) -> dict[str, Any]:
    return next(one for one in found.document["findings"] if one["effect"] == effect)


def test_what_was_planted_is_named_with_its_size(warmed: Diagnosed) -> None:
    """With one single exponential T, dT/dt and a settling are one; the rate needs 17 times its size."""
    assert warmed.document["verdict"] == "likely"
    found = finding(warmed, "accelerometer.bias_temperature")
    assert (found["kind"], found["confidence"], found["aliases"], found["unit"]) == (
        "instrument", "likely", ["accelerometer.bias_settling", "accelerometer.temperature_rate"], "g/K",
    )  # fmt: skip
    for axis, true in (("x", 8e-5), ("y", -5e-5), ("z", 9e-5)):
        got = found["coefficients"][axis]
        assert abs(got["value"] - true) < 4 * got["std"]


def test_the_document_is_diagnosis_2(warmed: Diagnosed) -> None:
    document = warmed.document
    keys = (
        "format",
        "verdict",
        "findings",
        "error",
        "parameters",
        "solution",
        "tests",
        "unnamed",
        "probabilities",
        "next_measurement",
    )
    assert set(keys) <= set(document)
    assert document["format"] == "diagnosis/2"
    assert all(math.isfinite(n) for n in numbers(document))
    assert all(0 < one["probability"] <= 1 for one in document["tests"])
    for row in document["parameters"]:
        assert row["shift_sigma"] * row["std"] == pytest.approx(
            row["after"] - row["before"], abs=1e-12 * abs(row["after"])
        )
    assert document["solution"]["format"] == "solution/1"


def test_the_error_falls_on_what_was_held_out(warmed: Diagnosed) -> None:
    row = next(one for one in warmed.document["error"] if one["quantity"] == "accelerometer dwells")
    assert row["held_out_after"] < 0.1 * row["held_out_before"]
    assert row["after"] < 0.1 * row["before"]
    assert "held out" in row["method"]


def test_with_a_temperature_effect_parameters_hold_at_25_degc(warmed: Diagnosed, uncertified: Diagnosed) -> None:
    assert warmed.document["solution"]["reference_temperature_c"] == 25.0
    assert uncertified.document["solution"]["reference_temperature_c"] != 25.0


def test_without_certificate_the_plan_is_what_the_bench_cannot_show(uncertified: Diagnosed) -> None:
    assert "free positions" in uncertified.document["not_separable"]["accelerometer.quadratic"]
    assert set(uncertified.document["not_separable"]) >= {"accelerometer.quadratic"}
    assert 'attitude = "free"' in uncertified.plan.read_text()


def test_two_faces_alone_are_exit_5_and_partial_says_how_level_they_stood(
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = DATA / "measured/ln100_two_positions"
    if not folder.is_dir():
        pytest.skip(f"no shared data at {DATA}: set STATION_DATA")
    assert cli.run(["diagnose", str(folder)]) == 5
    capsys.readouterr()
    assert cli.run(["diagnose", str(folder), "--partial"]) == 0
    reported = capsys.readouterr().out
    assert "not observable: accelerometer.scale_factor" in reported
    assert "0.34 deg" in reported
    assert "0.35" in reported


def test_a_period_that_solve_refuses_is_diagnosed(
    warmed: Diagnosed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = Path(shutil.copytree(warmed.folder, tmp_path / "c"))
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text.replace("sample_period_s = 0.05", "sample_period_s = 0.051"))
    assert cli.run(["solve", str(folder)]) == 3
    page = tmp_path / "out.html"
    assert cli.run(["diagnose", str(folder), "--json", str(tmp_path / "out.json"), "--html", str(page)]) == 0
    assert json.loads((tmp_path / "out.json").read_text())["format"] == "diagnosis/2"
    reported = capsys.readouterr().out
    assert f"{tmp_path / 'out.json'}: diagnosis of " in reported
    assert f"{page}: diagnosis of " in reported


def test_campaigns_of_two_units_are_not_diagnosed_together(
    warmed: Diagnosed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = Path(shutil.copytree(warmed.folder, tmp_path / "c"))
    text = (other / "campaign.toml").read_text()
    (other / "campaign.toml").write_text(text.replace('serial = "SIM-7"', 'serial = "SIM-8"'))
    assert cli.run(["diagnose", str(warmed.folder), "--validate", str(other)]) == 3
    assert "SIM-8" in capsys.readouterr().err


def test_another_campaign_is_predicted_by_what_was_found(warmed: Diagnosed, tmp_path: Path) -> None:
    planted = {"accelerometer.bias_temperature": {"x": 8e-5, "y": -5e-5, "z": 9e-5}}
    other = simulated(tmp_path / "other", planted, 13)
    out = tmp_path / "out.json"
    assert cli.run(["diagnose", str(warmed.folder), "--validate", str(other), "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    assert "validation:" in diagnosis_text(document)
    rows = [row for row in document["error"] if row["method"] == f"validation: {other}"]
    row = next(one for one in rows if one["quantity"] == "accelerometer dwells")
    assert row["after"] < 0.1 * row["before"]
    assert row["held_out_after"] < 0.1 * row["held_out_before"]
