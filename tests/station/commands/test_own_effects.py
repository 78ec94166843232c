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
from station.calibrated.calibration_applied import calibrated_inputs
from station.calibrated.surroundings import Surroundings
from station.errors import DataRefused
from station.files.effect_file import read_effect
from tests.station.campaign_writing import write_campaign
from tests.station.effect_examples import WARMING, WARMING_LAW, WARMING_SIZES

TRUTH = replace(
    Truth.example(7), temperature_rise_k=8.0, temperature_tau_s=500.0, heading_std_deg=0.02, sample_period_s=0.05
)
NAME, SOURCE = 'name = "warming_while_warm"', 'source = "'


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
        "gyroscope.warming_while_warm: what it depends on was not recorded",
    )
    altered = {**solved["effects"][0], "definition": WARMING.replace("T * T_rate", "T_rate * T")}
    with pytest.raises(DataRefused, match="take what was stored"):
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
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert sha256 in said[0]
    assert "bring back the file" in said[0]


def test_a_name_that_the_catalogue_took_since_leaves_records_as_they_are(
    recorded: Recorded, solved: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = WARMING.replace("warming_while_warm", "bias_temperature")  # as if written before the catalogue had it
    folder = tmp_path / "campaign"
    folder.mkdir()
    for file in recorded.folder.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "own.toml").write_text(text)
    listed = (
        (folder / "campaign.toml")
        .read_text()
        .replace("[[dwell]]", '[effects]\nfiles = ["own.toml"]\n[[dwell]]', 1)
    )
    (folder / "campaign.toml").write_text(listed)
    there = Recorded(folder, recorded.effect)
    found = there.solve()
    assert found["gyroscope"] == solved["gyroscope"]
    assert [one["definition"] for one in found["effects"]] == [text]
    out = tmp_path / "diagnosis.json"
    assert cli.run(["diagnose", str(folder), "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    assert "gyroscope.bias_temperature" not in {
        one["effect"] for one in [*document["tried"], *document["findings"]]
    }
    capsys.readouterr()
    assert (
        cli.run(["effects", "add", str(folder / "own.toml"), "--model", "FOG-3", "--db", str(tmp_path / "a.db")])
        == 3
    )
    assert "which the catalogue has" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["bias_temperature", "bias_drift", "magnetic"])
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
    (said,) = [text for text in found["warnings"] if "aux_fan" in text]
    assert said.startswith("gyroscope.fan_warm is left out: aux_fan not recorded")


@pytest.mark.parametrize("term", ["T / 0 * T_rate", "exp(1000) * T * T_rate", "1e300 * T * (T_rate / 1e-300)"])
@pytest.mark.filterwarnings("error")  # numpy's are no word to a user
def test_what_is_no_finite_number_is_named_and_left_out(term: str, recorded: Recorded, tmp_path: Path) -> None:
    endless = tmp_path / "endless.toml"
    endless.write_text(WARMING.replace("T * T_rate", term).replace("warming_while_warm", "endless"))
    found = recorded.solve("--effects", str(endless))
    assert "effects" not in found
    said = f"gyroscope.endless is left out: {term} is no finite number in this campaign"
    assert said in found["warnings"]


def test_two_that_are_one_in_this_design_are_not_both_fitted(recorded: Recorded, tmp_path: Path) -> None:
    twin = tmp_path / "twin.toml"
    twin.write_text(WARMING.replace("warming_while_warm", "twin").replace("T * T_rate", "2 * T_rate * T"))
    found = recorded.solve("--effects", str(recorded.effect), "--effects", str(twin))
    assert [effect["name"] for effect in found["effects"]] == ["gyroscope.warming_while_warm"]
    (said,) = [text for text in found["warnings"] if "twin" in text]
    assert said == "gyroscope.twin is left out: in this campaign it is one with gyroscope.warming_while_warm"


def test_a_diagnosis_has_it_in_the_model_from_the_start(
    recorded: Recorded, capsys: pytest.CaptureFixture[str]
) -> None:
    out = recorded.folder.parent / "diagnosis.json"
    command = ["diagnose", str(recorded.folder), "--effects", str(recorded.effect)]
    assert cli.run([*command, "--json", str(out), "--html", str(out.with_suffix(".html"))]) == 0
    page = out.with_suffix(".html").read_text()
    assert "<caption>In the model from the start: gyroscope.warming_while_warm" in page
    assert "<tr><td>x</td>" in page
    document = json.loads(out.read_text())
    assert document["verdict"] not in {"unexplained", "partly"}
    assert not [one for one in document["findings"] if one["effect"].startswith("gyroscope")]
    assert [one["name"] for one in document["solution"]["effects"]] == ["gyroscope.warming_while_warm"]


def test_try_says_whether_a_campaign_shows_it(recorded: Recorded, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["effects", "try", str(recorded.effect), str(recorded.folder)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("gyroscope.warming_while_warm: it is there, ")
    assert "deg/h/K/(K/min)" in said


def test_show_tells_what_an_effect_is(recorded: Recorded, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["effects", "show", str(recorded.effect)]) == 0
    said = capsys.readouterr().out
    assert "c (T * T_rate)" in said
    assert "temperature above 25 degC [K]" in said
    assert "before" not in said
    drift = recorded.effect.with_name("drift.toml")
    drift.write_text(WARMING.replace("T * T_rate", "u * t_step / (1 [s])").replace("deg/h/K/(K/min)", "ppm"))
    assert cli.run(["effects", "show", str(drift)]) == 0
    said = capsys.readouterr().out
    assert "what the sensor measures: rate [deg/s]" in said
    assert "it depends on the campaign or on what was before" in said
    assert cli.run(["effects", "show", "gyroscope.magnetic"]) == 0
    assert "in the catalogue" in capsys.readouterr().out
    nothing = str(recorded.folder.parent / "nothing.db")
    assert cli.run(["effects", "show", "gyroscope.magic", "--db", nothing]) == 3
    assert "gyroscope.magnetic" in capsys.readouterr().err


REFUSED = (
    ('term = "T * T_rate"', 'term = "T * humidity"', ":4: found humidity at column 5", "aux_NAME"),
    ('term = "T * T_rate"', 'term = "T.real"', ":4: found . at column 2", "+ - * /"),
    ('term = "T * T_rate"', "term = []", ":4: ", "at least 1"),
    ('unit = "deg/h/K/(K/min)"', 'unit = "deg/h/K"', ":4: found ", "what gyroscopes put out"),
    ('unit = "deg/h/K/(K/min)"', 'unit = "deg/h/mile"', ":5: found mile at column 7", "ppm"),
    ('triad = "gyroscope"', 'triad = "magnetometer"', ":3: ", "gyroscope"),
    ("plausible = 1.0", "plausible = 0", ":6: ", "greater than 0"),
    ("plausible = 1.0", 'plausible = 1.0\nsize = "x"', ":7: found unknown key 'size'", "plausible"),
    (NAME, 'name = "magnetic"', ":2: found gyroscope.magnetic, which the catalogue", "rename"),
    (NAME, 'name = "../x"', ":2: ", "a letter, then"),
    (SOURCE, 'shape.tau = {unit = "s", low = 1}\nsource = "', "high", "high to be given"),
    (SOURCE, 'shape.tau = {unit = "s", low = 9, high = 1, step = 2}\nsource = "', "unknown key", "low, high"),
    (SOURCE, 'shape.tau = {unit = "s", low = 9, high = 1}\nsource = "', "low = 9 above high = 1", "low below"),
    (SOURCE, 'shape.tau = {unit = "s", low = 1, high = 9}\nsource = "', "no tau in it", "every parameter"),
    (SOURCE, 'shape.w = {unit = "deg/hr", low = 1, high = 9}\nsource = "', ":7: found hr at column 5", "ppm"),
    (SOURCE, 'shape.T = {unit = "s", low = 1, high = 9}\nsource = "', ":7: found a parameter T", "no input"),
    ('unit = "deg/h/K/(K/min)"', 'unit = "deg/K^2/mile"', ":5: found mile at column 9 of 'deg/K^2/", "ppm"),
    ('unit = "deg/h/K/(K/min)"', 'unit = "(h**12)**12"', ":5: found **12 at column 8", "powers up to 12"),
    ('term = "T * T_rate"', 'term = "T * 3 [deg/hr]"', ":4: found hr at column 12", "ppm"),
    ('format = "effect/1"', 'format = "effect/2"', ":1: ", "effect/1"),
    ("T * T_rate", "T * T_rate\x00", "", "TOML"),
)  # fmt: skip


@pytest.mark.parametrize(("old", "new", "place", "expected"), REFUSED)
def test_a_bad_file_is_refused_in_one_line_with_its_place(
    old: str, new: str, place: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bad.toml"
    file.write_text(WARMING.replace(old, new))
    assert cli.run(["effects", "show", str(file)]) == 3
    (said,) = capsys.readouterr().err.strip().splitlines()
    assert str(file) in said
    assert place in said
    assert expected in said


def test_two_files_of_one_name_that_differ_are_refused(recorded: Recorded, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(WARMING.replace("plausible = 1.0", "plausible = 2.0"))
    command = ["solve", str(recorded.folder), "--effects", str(recorded.effect), "--effects", str(other)]
    assert cli.run(command) == 3
    assert cli.run(["solve", str(recorded.folder), "--effects", str(tmp_path / "none.toml")]) == 3


def test_a_term_that_only_takes_the_place_of_another_is_seen_and_not_kept(
    recorded: Recorded, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It fades in 300 s at the most, as a bias does that settles, and the law does not."""
    fading = tmp_path / "fading.toml"
    term = WARMING.replace("T * T_rate", "T * T_rate * exp(-t / tau)")
    fading.write_text(f'{term}shape.tau = {{unit = "s", low = 100, high = 300}}\n')
    assert cli.run(["effects", "try", str(fading), str(recorded.folder)]) == 0
    said = capsys.readouterr().out
    assert "seen (over all that was tried p = " in said
    assert "and not kept: gyroscope.bias_settling explains more, though that would be " in said
    assert "times larger than is plausible" in said


def test_a_parameter_at_the_end_of_its_range_is_said(
    recorded: Recorded, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    narrow = tmp_path / "narrow.toml"
    term = WARMING.replace("T * T_rate", "T * T_rate * exp(-t / tau)")
    narrow.write_text(f'{term}shape.tau = {{unit = "s", low = 1000, high = 9000}}\n')
    ends = "tau stands at the end of its range (1000 to 9000 s): widen it"
    found = recorded.solve("--effects", str(narrow))
    assert f"gyroscope.warming_while_warm: {ends}" in found["warnings"]
    capsys.readouterr()
    assert cli.run(["effects", "try", str(narrow), str(recorded.folder)]) == 0
    assert ends in capsys.readouterr().out
