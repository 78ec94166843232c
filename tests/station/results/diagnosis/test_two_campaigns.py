"""``station diagnose A B``: two campaigns of one unit tell what neither tells alone."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station import cli
from station.results.diagnosis.diagnosis_text import diagnosis_text
from tests.station.campaign_writing import write_campaign

BIAS_BY_TEMPERATURE = {"accelerometer.bias_temperature": {"x": 2e-5, "y": -3e-5, "z": 4e-5}}


def recorded(folder: Path, seed: int, turned: bool = True, **of: Any) -> Path:
    """Record one unit on one certified cube, as warm and where ``of`` says, the temperature steady.

    Not ``turned``: the accelerometers alone, which is quicker.
    """
    base: dict[str, Any] = {"effects": BIAS_BY_TEMPERATURE, "heading_std_deg": 0.02, "sample_period_s": 0.05}
    truth = replace(Truth.example(7), **(base | of))
    campaign = simulate_campaign(
        truth, seed, dwell_s=20.0, turns=turn_steps(1, 3.0) if turned else (), move_s=20.0, certificate_sigma=2e-7,
        draw_stated=False,
    )  # fmt: skip
    write_campaign(folder, campaign, truth.sample_period_s)
    return folder


def diagnosed(out: Path, *folders: Path) -> dict[str, Any]:
    assert cli.run(["diagnose", *map(str, folders), "--json", str(out)]) == 0
    document: dict[str, Any] = json.loads(out.read_text())
    return document


def names(document: dict[str, Any]) -> list[str]:
    return [one["effect"] for one in document["findings"]]


@pytest.fixture(scope="module")
def two_temperatures(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    root = tmp_path_factory.mktemp("temperatures")
    starts = {"cool": 22.0, "warm": 34.0}
    cool, warm = (
        recorded(root / name, i, turned=False, temperature_start_c=start)
        for i, (name, start) in enumerate(starts.items())
    )
    return cool, warm


def test_a_temperature_that_was_steady_in_each_is_found_between_the_two(
    two_temperatures: tuple[Path, Path], tmp_path: Path
) -> None:
    cool, warm = two_temperatures
    assert "accelerometer.bias_temperature" not in names(diagnosed(tmp_path / "one.json", cool))
    together = diagnosed(tmp_path / "both.json", cool, warm)
    found = next(one for one in together["findings"] if one["effect"] == "accelerometer.bias_temperature")
    for axis, true in BIAS_BY_TEMPERATURE["accelerometer.bias_temperature"].items():
        one = found["coefficients"][axis]
        assert abs(one["value"] - true) < 4 * one["std"]
        assert one["std"] < abs(true) / 5
    files = together["solution"]["provenance"]["files"]
    assert len(files) == 2 * (12 + 1)
    assert together["solution"]["reference_temperature_c"] == 25.0
    assert max(map(len, diagnosis_text(together).splitlines())) <= 80


@pytest.mark.proof
def test_two_sites_are_each_solved_with_its_own_gravity_and_latitude(tmp_path: Path) -> None:
    there = {"latitude_deg": 60.0, "gravity_m_s2": 9.8191}
    here, away = (recorded(tmp_path / n, s, effects={}, **w) for n, s, w in (("here", 3, {}), ("away", 4, there)))
    sites = [tomllib.loads((one / "campaign.toml").read_text())["site"]["latitude_deg"] for one in (here, away)]
    assert sites == pytest.approx([31.17, 60.0])
    together = diagnosed(tmp_path / "both.json", here, away)
    assert together["verdict"] != "unexplained"
    assert not [one for one in together["findings"] if one["kind"] == "instrument"]
    text = (away / "campaign.toml").read_text()
    (away / "campaign.toml").write_text(text.replace(f"latitude_deg = {sites[1]}", f"latitude_deg = {sites[0]}"))
    wrong = diagnosed(tmp_path / "wrong.json", here, away)
    assert wrong["verdict"] != "consistent"  # the Earth's rate is another there: it matters where
    assert wrong["log10_p"] < together["log10_p"] or names(wrong) != names(together)


def test_the_same_folder_twice_is_refused(
    two_temperatures: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    cool, _ = two_temperatures
    assert cli.run(["diagnose", str(cool), str(cool)]) == 3
    assert "the same bytes" in capsys.readouterr().err
