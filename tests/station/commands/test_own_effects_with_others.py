"""A declared effect in the model, and another that the campaign was planted with next to it: both are found."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station import cli
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING, WARMING_LAW, WARMING_SIZES

DECLARED, OTHER = "gyroscope.warming_while_warm", "gyroscope.g_sensitivity"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign whose folder declares the law, of a unit that has g-sensitivity as well."""
    found = tmp_path_factory.mktemp("with") / "campaign"
    truth = replace(
        Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, heading_std_deg=0.02,
        sample_period_s=0.05, effects={OTHER: {"xy": 2.0}},
    )  # fmt: skip
    campaign = simulate_campaign(
        truth,
        5,
        dwell_s=20.0,
        turns=turn_steps(1, 3.0),
        move_s=20.0,
        certificate_sigma=2e-7,
        also=((WARMING_LAW, {}),),
    )
    write_campaign(found, campaign, truth.sample_period_s)
    (found / "own.toml").write_text(WARMING)
    text = (found / "campaign.toml").read_text()
    table = '[effects]\nfiles = ["own.toml"]\n'
    (found / "campaign.toml").write_text(text.replace("[[dwell]]", f"{table}[[dwell]]", 1))
    return found


def test_a_diagnosis_finds_the_other_effect_with_the_declared_one(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "diagnosis.json"
    assert cli.run(["diagnose", str(folder), "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    (found,) = [one for one in document["findings"] if one["kind"] == "instrument"]
    assert found["effect"] == OTHER
    xy = found["coefficients"]["xy"]
    assert abs(xy["value"] - 2.0) < 4 * xy["std"] < 1.0
    (declared,) = document["solution"]["effects"]
    assert declared["name"] == DECLARED
    for axis, size in zip("xyz", WARMING_SIZES, strict=True):
        one = declared["coefficients"][axis]
        assert abs(one["value"] - size) < 4 * one["std"] < 1.0
