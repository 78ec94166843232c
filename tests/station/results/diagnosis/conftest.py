"""Diagnosed campaigns, each recorded and diagnosed once by the whole program."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station import cli
from tests.station.campaign_writing import write_campaign

DWELL_S = 20.0


@dataclass(frozen=True)
class Diagnosed:
    """A folder, what `station diagnose` made of it, and what it said."""

    folder: Path
    document: dict[str, Any]
    plan: Path
    page: str
    reported: str


def simulated(folder: Path, effects: Mapping[str, Mapping[str, float]], seed: int, **of: Any) -> Path:
    """Record a certified unit on a level slab into a folder, warming up by 8 K, with some effects planted."""
    truth = replace(
        Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, effects=effects, heading_std_deg=0.02,
        sample_period_s=0.05,
    )  # fmt: skip
    campaign = simulate_campaign(
        truth, seed, dwell_s=DWELL_S, turns=turn_steps(1, 3.0), move_s=20.0, **{"certificate_sigma": 2e-7, **of}
    )
    write_campaign(folder, campaign, truth.sample_period_s)
    return folder


def diagnose(folder: Path, *more: str) -> Diagnosed:
    out, plan, page = folder / "out.json", folder / "next.toml", folder / "page.html"
    options = ["--json", str(out), "--plan", str(plan), "--html", str(page)]
    assert cli.run(["diagnose", str(folder), *options, *more]) == 0
    from station.results.diagnosis.diagnosis_text import diagnosis_text

    document = json.loads(out.read_text())
    return Diagnosed(folder, document, plan, page.read_text(), diagnosis_text(document))


@pytest.fixture(scope="session")
def warmed(tmp_path_factory: pytest.TempPathFactory) -> Diagnosed:
    """A unit whose accelerometer bias follows temperature."""
    planted = {"accelerometer.bias_temperature": {"x": 8e-5, "y": -5e-5, "z": 9e-5}}
    return diagnose(simulated(tmp_path_factory.mktemp("warmed"), planted, 3))


@pytest.fixture(scope="session")
def uncertified(tmp_path_factory: pytest.TempPathFactory) -> Diagnosed:
    """A unit in a cube whose faces nobody measured."""
    return diagnose(simulated(tmp_path_factory.mktemp("uncertified"), {}, 4, certificate_sigma=None))
