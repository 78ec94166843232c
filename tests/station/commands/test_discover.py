"""``station diagnose --discover``: a law of no catalogue proposed, adopted as a file, and nothing else changed."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import ALL_POSITIONS, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import Dwell, Step, Turn, turn_steps
from station import cli
from station.files.campaign_folder.plan_toml import read_plan
from station.files.effect_file import read_effect
from station.results.certificate.laboratory import Laboratory
from station.results.certificate.missing_statements import missing, only_proposed
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING_LAW, WARMING_SIZES


def recorded(folder: Path, seed: int, plan: Sequence[Step] = (), start_c: float | None = None) -> Path:
    """A unit with the law T dT/dt, planted by plain numpy, that warms up by 8 K; hands that do a plan's steps."""
    truth = replace(
        Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, heading_std_deg=0.02,
        sample_period_s=0.05,
    )  # fmt: skip
    truth = truth if start_c is None else replace(truth, temperature_start_c=start_c)
    positions = [step.position for step in plan if isinstance(step, Dwell)] or ALL_POSITIONS
    campaign = simulate_campaign(
        truth, seed, dwell_s=20.0, move_s=20.0, certificate_sigma=2e-7, also=((WARMING_LAW, {}),),
        turns=[step for step in plan if isinstance(step, Turn)] or turn_steps(1, 3.0),
        positions=positions,
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


def test_the_page_shows_the_term_and_its_plot(searched: Path) -> None:
    page = (searched / "page.html").read_text()
    assert "T * T_rate" in page
    assert page.count("<svg") >= 2
    assert "10176 terms were searched" in page or "terms were searched: one is proposed" in page


def test_what_is_adopted_is_an_effect_1_of_that_campaign(searched: Path) -> None:
    out = searched / "found.toml"
    assert cli.run(["effects", "adopt", str(searched / "found.json"), "--out", str(out)]) == 0
    effect = read_effect(out)
    assert effect.term.terms == ("T * T_rate",)
    assert effect.origin is not None


def test_hands_that_do_the_plan_leave_fewer_readings(searched: Path) -> None:
    """Diagnosed with what the plan asks for, in a room 5 K warmer as it says, the law stands against fewer."""
    first = _read(searched / "found.json")["findings"][-1]
    second = recorded(searched / "second", 31, read_plan(searched / "next.toml"), 30.0)
    out = searched / "both.json"
    assert cli.run(["diagnose", str(searched / "campaign"), str(second), "--discover", "--json", str(out)]) == 0
    one = next(each for each in _read(out)["findings"] if each["confidence"] == "proposed")
    assert one["term"] == ["T * T_rate"]
    assert one["readings_in_all"] < first["readings_in_all"]


def test_only_other_data_confirm_what_was_found(searched: Path, capsys: pytest.CaptureFixture[str]) -> None:
    law, again, later = searched / "law.toml", searched / "again.toml", recorded(searched / "later", 23)
    assert cli.run(["effects", "adopt", str(searched / "found.json"), "--out", str(law)]) == 0
    assert "proposed: no data but those it was found in" in capsys.readouterr().out
    assert read_effect(law).is_only_proposed
    for folder, is_confirmed in ((searched / "campaign", False), (later, True)):
        out = searched / "with_it.json"
        assert cli.run(["diagnose", str(folder), "--effects", str(law), "--json", str(out)]) == 0
        assert cli.run(["effects", "adopt", str(out), "--out", str(again)]) == 0
        assert ("confirmed by SIM-FOG3" in capsys.readouterr().out) is is_confirmed
        file = read_effect(again)
        assert file.is_only_proposed is not is_confirmed
        assert file.origin is not None
        assert bool(file.origin.confirmed_by) is is_confirmed
        assert file.term == read_effect(law).term


def test_no_certificate_rests_on_what_is_only_proposed(searched: Path) -> None:
    law = searched / "proposed.toml"
    assert cli.run(["effects", "adopt", str(searched / "found.json"), "--out", str(law)]) == 0
    file = read_effect(law)
    entry = {"name": file.name, "definition": file.text, "sha256": file.sha256}
    assert only_proposed({"effects": [entry, {"name": "gyroscope.magnetic"}]}) == [file.name]
    laboratory = Laboratory.model_validate({"format": "laboratory/1"})
    assert f"confirmation of {file.name}" in dict(missing({"effects": [entry]}, laboratory))
