"""The generated pages are up to date, and every format of files is on its page."""

import json
import re
import runpy
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from station import cli
from station.results.result_formats import RESULTS
from tests.paths import ROOT
from tests.station.campaign_writing import write_campaign

GENERATOR = runpy.run_path(str(ROOT / "docs/generate.py"))
INPUTS, PAGES, REFERENCE = (GENERATOR[name] for name in ("INPUTS", "PAGES", "REFERENCE"))
ELSEWHERE = {
    "attitude-log/1": "docs/explanation/attitude.md",
    "can-map/1": "docs/how-to/can.md",
    "fixtures/1": "docs/reference/file-formats.md",
    "evidence/1": "docs/contributing/station-tests.md",
}
INTERNAL = {"kept/1"}  # what `station resolve` keeps of its own between two runs


@pytest.mark.parametrize("name", PAGES)
def test_a_generated_page_is_up_to_date(name: str) -> None:
    assert (REFERENCE / name).read_text(encoding="utf-8") == PAGES[name](), "run: python docs/generate.py"


def test_every_format_that_the_program_names_is_described() -> None:
    sources = [path for folder in ("station", "drivers", "fixtures_db") for path in (ROOT / folder).rglob("*.py")]
    named = {name for path in sources for name in re.findall(r'"([a-z-]+/1)"', path.read_text(encoding="utf-8"))}
    described = {*INPUTS, *RESULTS, *ELSEWHERE, *INTERNAL}
    assert named <= described
    for name, page in ELSEWHERE.items():
        assert name in (ROOT / page).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Return files that commands wrote: of a small campaign, of a drive."""
    folder = tmp_path_factory.mktemp("results")
    truth = replace(Truth.example(3), sample_period_s=0.05)
    write_campaign(folder / "c", simulate_campaign(truth, 3, dwell_s=8.0, turns=()), 0.05)
    calibration, samples = ROOT / "docs/examples/calibration.json", folder / "samples.csv"
    applied = ["apply", str(ROOT / "docs/examples/drive.csv"), "--calibration", str(calibration), "--out"]
    assert cli.run([*applied, str(samples)]) == 0
    named = {"solve": folder / "c", "diagnose": folder / "c", "noise": folder / "c", "attitude": samples}
    for command, path in named.items():
        assert cli.run([command, str(path), "--json", str(folder / f"{command}.json")]) == 0
    return [*(folder / f"{command}.json" for command in named), folder / "samples.csv.json", calibration]


def test_every_key_of_a_result_is_described(results: list[Path]) -> None:
    for path in results:
        document = json.loads(path.read_text(encoding="utf-8"))
        assert set(document) - {"format"} <= set(RESULTS[document["format"]].keys), path.name
