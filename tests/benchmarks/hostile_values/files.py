"""Every kind of file that a user hands in: an example that is right, and the program's way of taking it in."""

import shutil
import sys
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

from station import cli
from station.errors import explain
from station.files.campaign_folder.plan_file import read_mounting, read_plan
from station.files.limits_file import example_limits
from station.files.scenario import read_scenario
from station.files.scenario_schema import read_faults
from station.results.certificate.laboratory import read_laboratory
from tests.paths import ROOT
from tests.station.effect_examples import DEAD_ZONE, WARMING
from tests.station.results.certificate.factory import EXAMPLE


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file: its tables when right, and what takes in a folder with the file ``name`` in it."""

    name: str
    tables: Mapping[str, Any]
    take: Callable[[Path], int]


def _by(read: Callable[[Path], object]) -> Callable[[Path], int]:
    def take(path: Path) -> int:
        try:
            read(path)
        except Exception as error:
            code, line = explain(error)
            sys.stderr.write(cli.one_line(line) + "\n")
            return code
        return 0

    return take


def _command(*before: str, after: Sequence[str] = (), database: Path | None = None) -> Callable[[Path], int]:
    """Return what runs a command on the file; with a copy of a ``database``, another one each time."""

    def take(path: Path) -> int:
        if database is None:
            return cli.run([*before, str(path), *after])
        copy = shutil.copyfile(database, path.with_name("copy.db"))
        return cli.run([*before, str(path), *after, "--db", str(copy)])

    return take


HERE, SCENARIOS = Path(__file__).parent, ROOT / "docs" / "scenarios"


def _read(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def _drive() -> dict[str, Any]:
    tables = _read(SCENARIOS / "drive.toml")
    tables["imu"]["track"] = str(SCENARIOS / "drive.csv")
    return tables


def kinds(folder: Path, campaign: dict[str, Any], fixtures: dict[str, Any]) -> dict[str, Kind]:
    """Return all kinds; ``campaign`` of a folder that lies in ``folder``, ``fixtures`` as exported."""
    laboratory = _read(EXAMPLE) | {"item": {"received": date(2026, 3, 2), "condition": "no damage"}}
    limits = ("fixtures", "limits", "FOG-3", "--db", str(folder / "hostile.db"), "--import")
    effect = _command("effects", "add", after=("--model", "FOG-3"), database=folder / "empty.db")

    def solve(path: Path) -> int:
        return cli.run(["solve", str(path.parent), "--json", str(folder / "o.json")])

    plan, faults = _read(HERE / "plan.toml"), _read(HERE / "faults.toml")
    sizes = ("t1", "t2", "t3", "t4-1", "t4-2", "t5", "t6", "t7", "t8", "t9", "t10")
    items = {"side_mm": 400.0, "tolerance_mm": dict.fromkeys(sizes, 0.04)}
    scenario = partial(Kind, "scenario.toml", take=_by(read_scenario))
    return {
        "campaign": Kind("campaign.toml", campaign, solve),
        "plan": Kind("plan.toml", plan, _by(lambda path: (read_plan(path), read_mounting(path)))),
        "limits": Kind("limits.toml", tomllib.loads(example_limits("FOG-3")), _command(*limits)),
        "fixtures": Kind("fixtures.toml", fixtures, _command("fixtures", "import", database=folder / "empty.db")),
        "effect": Kind("effect.toml", tomllib.loads(DEAD_ZONE), effect),
        "lagging_effect": Kind("effect.toml", tomllib.loads(WARMING), effect),
        "laboratory": Kind("laboratory.toml", laboratory, _by(read_laboratory)),
        "faults": Kind("faults.toml", faults, _by(lambda path: read_faults(path, is_on_can=True))),
        "scenario": scenario(_read(SCENARIOS / "troubles.toml")),
        "drive": scenario(_drive()),
        "calibration_scenario": scenario(_read(SCENARIOS / "calibration.toml")),
        "tolerance": Kind("items.toml", items, _command("fixtures", "tolerance", "--cubes", "1000", "--items")),
    }
