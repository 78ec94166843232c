"""``station resolve`` on recorded campaigns: what changed is said, what is stored stays."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.campaigns import accept_step, set_state, start_campaign
from fixtures_db.database import open_db
from fixtures_db.imu_models import Limit, set_limits
from fixtures_db.stored_calibrations import CalibrationFacts, accept_calibration
from fixtures_db.verification import take_anchor
from procedures.calibration.joint_calibration import solve
from station import cli
from station.files.atomic_file import write_json
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.files.sha256sums import append_hash
from station.results.resolve.parallel_map import open_engine
from station.results.resolve.work_item import code_hash
from station.results.result_formats import document_of
from station.results.solution_json import solution_document
from tests.fixtures_db.factory import NOON
from tests.station.campaign_writing import write_campaign

Resolve = Callable[..., tuple[int, dict[str, Any], str]]
SIGMAS = 3.0


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three campaigns with their hashes: S1 to be stored, S2 with a solution.json, S3 with nothing else."""
    root = tmp_path_factory.mktemp("fleet")
    for seed in (1, 2, 3):
        truth = replace(Truth.example(seed), serial=f"S{seed}")
        folder = root / f"S{seed}"
        write_campaign(folder, simulate_campaign(truth, seed, dwell_s=20.0, turns=()), truth.sample_period_s)
        loaded = read_for_solve([folder])[0]
        for name, sha256 in loaded.files.items():
            append_hash(folder, name, sha256)
        if seed == 2:
            document = document_of(solution_document(solve([loaded.campaign]), [loaded]))
            document["warnings"] = []
            document["accelerometer"]["bias"]["value"][1] += SIGMAS * document["accelerometer"]["bias"]["std"][1]
            write_json(folder / "solution.json", document)
    return root


@pytest.fixture
def fleet(recorded: Path, tmp_path: Path) -> Path:
    """The same in a database, S1 with a stored calibration whose bias x is 3 sigma off."""
    root = Path(shutil.copytree(recorded, tmp_path / "fleet"))
    with open_db(tmp_path / "s.db") as database:
        for folder in sorted(root.iterdir()):
            loaded = read_for_solve([folder])[0]
            model, serial = loaded.tables.imu.model, loaded.tables.imu.serial
            with database.write() as session:
                start_campaign(session, str(folder), model=model, serial=serial, started_utc=NOON)
                for step in loaded.steps:
                    file = step.table.file
                    accept_step(session, str(folder), name=file, file=file, sha256=loaded.files[file],
                                accepted_utc=NOON)  # fmt: skip
                set_state(session, str(folder), "recorded")
                if serial == "S1":
                    found = solve([loaded.campaign])
                    assert found.accelerometer is not None
                    bias = found.accelerometer.bias
                    moved = replace(bias, value=bias.value + SIGMAS * bias.std * [1, 0, 0])
                    old = replace(found, accelerometer=replace(found.accelerometer, bias=moved))
                    facts = CalibrationFacts(model, serial, "fog-station 0.0.1", loaded.files, NOON, NOON)
                    accept_calibration(session, old, facts, campaign_folder=str(folder))
    return root


@pytest.fixture
def resolve(fleet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Resolve:
    """Run the command; return its exit code, resolve/1 by folder name, and what it says on stderr."""

    def run(*arguments: str) -> tuple[int, dict[str, Any], str]:
        out = tmp_path / "resolve.json"
        where = ("--out", str(tmp_path / "kept"), "--db", str(tmp_path / "s.db"), "--json", str(out))
        one = () if "--scheduler" in arguments else ("--workers", "1")
        code = cli.run(["resolve", *arguments, *one, *where])
        document = json.loads(out.read_text()) if out.exists() else {"campaigns": []}
        return code, {Path(one["folder"]).name: one for one in document["campaigns"]}, capsys.readouterr().err

    return run


def stored(fleet: Path) -> tuple[Any, dict[str, bytes]]:
    with open_db(fleet.parent / "s.db") as database, database.read() as session:
        return take_anchor(session), {str(file): file.read_bytes() for file in fleet.rglob("*") if file.is_file()}


def test_each_campaign_is_held_against_what_was_known_of_it_in_its_own_sigma(
    resolve: Resolve, fleet: Path
) -> None:
    before = stored(fleet)
    code, found, _ = resolve("--all")
    assert code == 0
    assert stored(fleet) == before
    assert [one["outcome"] for one in found.values()] == ["solved"] * 3
    kinds = {name: one["before"]["kind"] for name, one in found.items() if "before" in one}
    assert kinds == {"S1": "calibration", "S2": "solution"}
    for name, axis in (("S1", "x"), ("S2", "y")):
        shifts = {key: row["shift_sigma"] for key, row in found[name]["shifts"].items()}
        moved = f"accelerometer.bias.{axis}"
        assert shifts.pop(moved) == pytest.approx(-SIGMAS, abs=1e-6)
        assert np.abs(list(shifts.values())).max() < 1e-6  # the same code on the same counts
    assert "shifts" not in found["S3"]
    assert "new_warnings" not in found["S1"]  # a calibration has none to compare with
    assert found["S2"]["new_warnings"]


def test_a_second_run_computes_only_what_has_other_files(resolve: Resolve, fleet: Path) -> None:
    first = resolve("--all")[1]
    assert not any(one["was_kept"] for one in first.values())
    file = fleet / "S2" / "campaign.toml"
    file.write_text(file.read_text() + "\n# a note\n")
    code, found, _ = resolve("--all")
    assert {name: one["was_kept"] for name, one in found.items()} == {"S1": True, "S2": False, "S3": True}
    assert found["S1"]["shifts"] == first["S1"]["shifts"]
    assert code == 1  # a recording was altered
    assert [(row["file"], row["record"]) for row in found["S2"]["altered"]] == [(file.name, "SHA256SUMS")]


def test_one_that_is_refused_or_gone_stops_no_other(resolve: Resolve, fleet: Path) -> None:
    (fleet / "S1" / "campaign.toml").write_text("format = 7\n")
    shutil.rmtree(fleet / "S2")
    code, found, _ = resolve("--all")
    assert code == 1
    assert {name: one["outcome"] for name, one in found.items()} == {
        "S1": "refused",
        "S2": "missing",
        "S3": "solved",
    }
    assert "campaign.toml:1: found" in found["S1"]["reason"]
    assert found["S1"]["exit_code"] == 3
    assert "campaign.toml" in [row["file"] for row in found["S1"]["altered"]]


def test_a_verdict_that_turns_to_fail_on_the_limits_of_today_ends_with_1(resolve: Resolve, tmp_path: Path) -> None:
    bias = resolve(str(tmp_path / "fleet" / "S1"))[1]["S1"]["shifts"]["accelerometer.bias.x"]
    edge = (bias["before"] + bias["now"]) / 2
    limit = Limit("accelerometer.bias.x", edge, None, "g")
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        set_limits(session, Truth.example(1).model, [limit])
    code, found, _ = resolve(str(tmp_path / "fleet" / "S1"))
    assert code == 1
    assert found["S1"]["verdict"]["before"] == "PASS"
    assert found["S1"]["verdict"]["now"] == "FAIL"
    assert "accelerometer bias x" in found["S1"]["verdict"]["reason"]


@pytest.mark.proof
def test_the_workers_of_a_cluster_give_the_same_and_say_what_they_cannot_read(
    resolve: Resolve, fleet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = resolve("--all")[1]
    shutil.rmtree(tmp_path / "kept")
    code_hash.cache_clear()  # the code as it is now, which is what new workers read
    with open_engine(2) as engine:
        address = engine.client.scheduler.address  # type: ignore[union-attr]
        there = resolve("--all", "--scheduler", address)[1]
        assert [(one.get("reason"), one.get("was_kept")) for one in there.values()] == [(None, False)] * 3
        assert {name: one.get("shifts") for name, one in there.items()} == {
            name: one.get("shifts") for name, one in here.items()
        }
        gone = fleet.rename(tmp_path / "elsewhere")
        monkeypatch.setattr(Path, "is_dir", lambda path: True)  # this machine has it, the workers have not
        found = resolve("--all", "--scheduler", address)[1]
    assert gone.exists()
    assert {one["outcome"] for one in found.values()} == {"refused"}
    assert all(f"no such folder on {one['host']}" in one["reason"] for one in found.values())


def test_a_campaign_is_diagnosed_again_and_what_changed_is_reported(
    resolve: Resolve, fleet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, file = fleet / "S2", fleet / "S2" / "diagnosis.json"
    first = resolve(str(folder))[1]["S2"]["diagnosis"]
    assert set(first) == {"verdict", "findings"}  # nothing was known of it
    assert cli.run(["diagnose", str(folder), "--json", str(file)]) == 0
    same = resolve(str(folder))[1]["S2"]["diagnosis"]
    assert same["verdict"] == {"before": first["verdict"]["now"], "now": first["verdict"]["now"]}
    assert same["gained"] == same["lost"] == same["changed"] == []
    document = json.loads(file.read_text())
    document["verdict"] = "established"
    document["findings"] = [
        {"effect": "gyroscope.magnetic", "kind": "instrument", "confidence": "established", "aliases": []}
    ]
    file.write_text(json.dumps(document))
    command = ["resolve", str(folder), "--workers", "1", "--out", str(tmp_path / "kept")]
    capsys.readouterr()
    assert cli.run([*command, "--db", str(tmp_path / "s.db")]) == 0
    reported = " ".join(capsys.readouterr().out.split())
    assert "1 with another diagnosis" in reported
    assert f"diagnosis: established before, {first['verdict']['now']} now" in reported
    assert "no more found: gyroscope.magnetic" in reported
    document["solution"]["provenance"]["files"] = {}  # of other recordings: not of this campaign
    file.write_text(json.dumps(document))
    assert set(resolve(str(folder))[1]["S2"]["diagnosis"]) == {"verdict", "findings"}
