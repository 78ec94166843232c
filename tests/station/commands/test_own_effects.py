"""Effects of one's own: a file, in the model of solve and diagnose, held to its hash, refused in one line."""

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station import cli
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Surroundings
from station.errors import DataRefused
from station.files.effect_file import read_effect
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING, WARMING_LAW, WARMING_SIZES

TRUTH = replace(
    Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, heading_std_deg=0.02, sample_period_s=0.05
)


@dataclass(frozen=True)
class Recorded:
    folder: Path
    effect: Path

    def solve(self, *more: str) -> dict[str, Any]:
        out = self.folder.parent / "solution.json"
        assert cli.run(["solve", str(self.folder), "--json", str(out), *more]) == 0
        document: dict[str, Any] = json.loads(out.read_text())
        return document


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """A unit whose gyroscopes follow a law that no catalogue holds, and that law as a file."""
    top = tmp_path_factory.mktemp("own")
    campaign = simulate_campaign(
        TRUTH,
        5,
        dwell_s=20.0,
        turns=turn_steps(1, 3.0),
        move_s=20.0,
        certificate_sigma=2e-7,
        also=((WARMING_LAW, {}),),
    )
    write_campaign(top / "campaign", campaign, TRUTH.sample_period_s)
    (top / "effect.toml").write_text(WARMING)
    return Recorded(top / "campaign", top / "effect.toml")


@pytest.fixture(scope="module")
def solved(recorded: Recorded) -> dict[str, Any]:
    return recorded.solve("--effects", str(recorded.effect))


def test_a_solve_with_the_law_finds_it_and_the_truth(recorded: Recorded, solved: dict[str, Any]) -> None:
    (effect,) = solved["effects"]
    assert effect["name"] == "gyroscope.warming_while_warm"
    assert effect["unit"] == "deg/h/K/(K/min)"
    for axis, planted in zip("xyz", WARMING_SIZES, strict=True):
        one = effect["coefficients"][axis]
        assert abs(one["value"] - planted) < 4 * one["std"] < 1.0
    assert solved["residual"]["p_value"] > 1e-3
    without = recorded.solve()
    assert without["residual"]["p_value"] < 1e-6
    assert "effects" not in without
    bias = solved["gyroscope"]["bias"]
    error = np.array(bias["value"]) - TRUTH.powered_on(_power(5)).gyro_d_deg_s * 3600
    assert np.all(np.abs(error) < 4.5 * np.array(bias["std"]))
    assert solved["reference_temperature_c"] == 25.0


def _power(seed: int) -> np.random.Generator:
    """The draw of the turn-on biases, as the simulated bench makes it."""
    return np.random.default_rng(np.random.SeedSequence(seed).spawn(3)[1])


def test_the_solution_names_the_effect_by_its_hash_and_holds_it_whole(
    recorded: Recorded, solved: dict[str, Any]
) -> None:
    file = read_effect(recorded.effect)
    assert solved["effects"][0]["sha256"] == file.sha256
    assert solved["effects"][0]["definition"] == WARMING
    assert solved["provenance"]["files"][str(recorded.effect)] == file.sha256


def test_what_the_solution_holds_is_taken_off_later_rates(solved: dict[str, Any]) -> None:
    k, D = (np.array(solved["gyroscope"][key]["value"]) for key in ("scale_factor", "bias"))
    counts = np.tile(k * D / 3600, (2, 1))  # of a unit at rest in inertial space
    warm = Surroundings(temperature=np.array([25.0, 31.0]), temperature_rate=np.array([0.5, 0.5]))
    found = calibrated_inputs(solved, None, counts, warm)
    assert found.not_applied == ()
    assert found.omega is not None
    value = np.array([solved["effects"][0]["coefficients"][axis]["value"] for axis in "xyz"])
    E = np.array(solved["gyroscope"]["misalignment"]["value"])
    expected = np.stack((np.zeros(3), -np.linalg.inv(E) @ value * 6.0 * 0.5 / 3600))
    assert np.allclose(found.omega, expected, rtol=1e-9, atol=1e-12)
    assert calibrated_inputs(solved, None, counts).not_applied == (
        "gyroscope.warming_while_warm: the quantity that it depends on was not recorded",
    )
    altered = {**solved["effects"][0], "definition": WARMING.replace("T * T_rate", "T_rate * T")}
    with refused(DataRefused):
        calibrated_inputs({**solved, "effects": [altered]}, None, counts, warm)


def test_a_folder_says_what_it_is_solved_with(
    recorded: Recorded, solved: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "campaign"
    folder.mkdir()
    for file in recorded.folder.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "own.toml").write_text(WARMING)
    sha256 = read_effect(recorded.effect).sha256
    text = (folder / "campaign.toml").read_text()
    table = f'[effects]\nfiles = ["own.toml"]\nsha256 = ["{sha256}"]\n'
    (folder / "campaign.toml").write_text(text.replace("[[dwell]]", f"{table}[[dwell]]", 1))
    there = Recorded(folder, recorded.effect)
    found = there.solve()
    assert found["effects"] == solved["effects"]
    assert found["gyroscope"] == solved["gyroscope"]
    assert found["provenance"]["files"]["own.toml"] == sha256
    assert there.solve("--effects", str(recorded.effect))["effects"] == found["effects"]  # the same file, once

    (folder / "own.toml").write_text(WARMING.replace("plausible = 1.0", "plausible = 2.0"))
    capsys.readouterr()
    assert cli.run(["solve", str(folder)]) == 3
    assert sha256 in capsys.readouterr().err


@pytest.mark.parametrize("name", ["bias_temperature", "magnetic"])
def test_what_is_taken_off_is_what_the_entry_defines(solved: dict[str, Any], name: str) -> None:
    counts, (entry,) = np.ones((2, 3)), solved["effects"]
    warm = Surroundings(temperature=np.array([25.0, 31.0]), temperature_rate=np.array([0.5, 0.5]))
    text = WARMING.replace("warming_while_warm", name)
    sha256 = hashlib.sha256(text.encode()).hexdigest()
    named = {**entry, "name": f"gyroscope.{name}", "definition": text, "sha256": sha256}
    expected, found = (calibrated_inputs({**solved, "effects": [e]}, None, counts, warm) for e in (entry, named))
    assert found.not_applied == expected.not_applied == ()
    assert found.omega is not None
    assert expected.omega is not None
    assert np.array_equal(found.omega, expected.omega)


def test_what_a_campaign_lacks_is_named_and_left_out(recorded: Recorded, tmp_path: Path) -> None:
    fan = tmp_path / "fan.toml"
    fan.write_text(
        WARMING.replace("T * T_rate", "T * aux_fan").replace("/(K/min)", "/unit").replace("warming_while", "fan")
    )
    found, without = recorded.solve("--effects", str(fan)), recorded.solve()
    assert "effects" not in found
    assert found["gyroscope"] == without["gyroscope"]
    (reported,) = [text for text in found["warnings"] if "aux_fan" in text]
    assert reported.startswith("gyroscope.fan_warm")


@pytest.mark.parametrize("term", ["T / 0 * T_rate", "exp(1000) * T * T_rate"])
@pytest.mark.filterwarnings("error")  # numpy's are no word to a user
def test_what_is_no_finite_number_is_named_and_left_out(term: str, recorded: Recorded, tmp_path: Path) -> None:
    endless = tmp_path / "endless.toml"
    endless.write_text(WARMING.replace("T * T_rate", term).replace("warming_while_warm", "endless"))
    found = recorded.solve("--effects", str(endless))
    assert "effects" not in found
    assert any(text.startswith("gyroscope.endless") and term in text for text in found["warnings"])


def test_two_that_are_one_in_this_design_are_not_both_fitted(recorded: Recorded, tmp_path: Path) -> None:
    twin = tmp_path / "twin.toml"
    twin.write_text(WARMING.replace("warming_while_warm", "twin").replace("T * T_rate", "2 * T_rate * T"))
    found = recorded.solve("--effects", str(recorded.effect), "--effects", str(twin))
    assert [effect["name"] for effect in found["effects"]] == ["gyroscope.warming_while_warm"]
    (reported,) = [text for text in found["warnings"] if "twin" in text]
    assert "gyroscope.warming_while_warm" in reported


def test_try_says_whether_a_campaign_shows_it(
    recorded: Recorded, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second fades in 300 s at the most, and the law does not."""
    fading = tmp_path / "fading.toml"
    term = WARMING.replace("T * T_rate", "T * T_rate * exp(-t / tau)")
    fading.write_text(f'{term}shape.tau = {{unit = "s", low = 100, high = 300}}\n')
    shown = {recorded.effect: "it is present, established", fading: "not found: its probability is"}
    for file, words in shown.items():
        assert cli.run(["effects", "try", str(file), str(recorded.folder)]) == 0
        assert words in capsys.readouterr().out
