"""``station diagnose --discover``: a law of no catalogue proposed, adopted as a file, and nothing else changed."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station import cli
from station.files.campaign_folder.plan_file import read_plan
from station.files.effect_file import read_effect
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import missing, only_proposed
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING_LAW, WARMING_SIZES

pytestmark = pytest.mark.proof


def recorded(folder: Path, seed: int) -> Path:
    """A unit with the law T dT/dt, planted by plain numpy, that warms up by 8 K."""
    truth = replace(
        Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, heading_std_deg=0.02,
        sample_period_s=0.05,
    )  # fmt: skip
    campaign = simulate_campaign(
        truth, seed, dwell_s=20.0, move_s=20.0, certificate_sigma=2e-7, also=((WARMING_LAW, {}),),
        turns=turn_steps(1, 3.0),
    )  # fmt: skip
    write_campaign(folder, campaign, truth.sample_period_s)
    return folder


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the campaign, what is found in it, and the page."""
    folder = tmp_path_factory.mktemp("searched")
    recorded(folder / "campaign", 6)
    options = ["--json", str(folder / "found.json"), "--html", str(folder / "page.html")]
    options += ["--plan", str(folder / "next.toml")]
    assert cli.run(["diagnose", str(folder / "campaign"), "--discover", *options]) == 0
    return folder


def _read(path: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(path.read_text())
    return document


def test_the_law_is_proposed_with_its_sizes(searched: Path) -> None:
    document = _read(searched / "found.json")
    one = document["findings"][-1]
    assert one["confidence"] == "proposed"
    assert one["term"] == ["T * T_rate"]
    assert one["latex"] == r"c\,T\,\dot T"
    for axis, size in zip("xyz", WARMING_SIZES, strict=True):
        found = one["coefficients"][axis]
        assert abs(found["value"] - size) < 4 * found["std"] < 0.5
    assert all(each["correlation"] > 0.9 for each in one["readings"])
    assert document["searched"]["terms"] > 9000


def test_the_next_measurement_is_a_plan_that_parts_readings(searched: Path) -> None:
    one = _read(searched / "found.json")["findings"][-1]
    assert one["next"]["parts"] >= 1
    assert 5 < one["next"]["minutes"] < 120
    assert sum(each["expected_chi2"] >= 16 for each in one["readings"]) <= one["next"]["parts"]
    assert f"in {one['next']['minutes']:.0f} minutes" in one["separate_by"]
    assert len(read_plan(searched / "next.toml")) >= 6


def test_verdict_and_solution_are_as_without_the_search(searched: Path) -> None:
    out = searched / "plain.json"
    assert cli.run(["diagnose", str(searched / "campaign"), "--json", str(out)]) == 0
    plain, document = _read(out), _read(searched / "found.json")
    for each in (plain, document):
        del each["solution"]["provenance"]
    for key in ("verdict", "p_value", "solution", "parameters", "error", "next_measurement"):
        assert plain[key] == document[key], key
    assert plain["findings"] == document["findings"][:-1]


def test_the_data_it_was_found_in_do_not_confirm_it(searched: Path) -> None:
    law, again, out = (searched / name for name in ("law.toml", "again.toml", "with_it.json"))
    assert cli.run(["effects", "adopt", str(searched / "found.json"), "--out", str(law)]) == 0
    assert cli.run(["diagnose", str(searched / "campaign"), "--effects", str(law), "--json", str(out)]) == 0
    assert cli.run(["effects", "adopt", str(out), "--out", str(again)]) == 0
    for file in (read_effect(law), read_effect(again)):
        assert file.term.terms == ("T * T_rate",)
        assert file.is_only_proposed
        assert file.origin is not None
        assert not file.origin.confirmed_by


def test_no_certificate_rests_on_what_is_only_proposed(searched: Path) -> None:
    law = searched / "proposed.toml"
    assert cli.run(["effects", "adopt", str(searched / "found.json"), "--out", str(law)]) == 0
    file = read_effect(law)
    entry = {"name": file.name, "definition": file.text, "sha256": file.sha256}
    assert only_proposed({"effects": [entry, {"name": "gyroscope.magnetic"}]}) == [file.name]
    laboratory = Laboratory.model_validate({"format": "laboratory/1"})
    assert f"confirmation of {file.name}" in dict(missing({"effects": [entry]}, laboratory))
