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


PLAN = """
format = "plan/1"
[fixture]
imu_axes = ["+x", "+y", "+z"]
[[dwell]]
seconds = 100.0
position = 1
[[dwell]]
seconds = 100.0
position = 2
[[turn]]
axis = "x"
direction = "+"
revolutions = 1
start_position = 1
seconds = 5.0
speed_deg_s = 30.0
[[soak]]
seconds = 100.0
position = 1
[[monitor]]
seconds = 60.0
position = 1
laws = ["mixer"]
"""
ITEMS = "side_mm = 400.0\n[tolerance_mm]\n" + "".join(
    f"{name} = 0.04\n" for name in ("t1", "t2", "t3", "t4-1", "t4-2", "t5", "t6", "t7", "t8", "t9", "t10")
)
FAULTS = """
[[fault]]
kind = "frame_lost"
at_s = 15.0
every_s = 20.0
[[fault]]
kind = "unplug"
at_s = 70.0
seconds = 4.0
"""


def _text(name: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / "docs" / name).read_text())


def _drive() -> dict[str, Any]:
    tables = _text("scenarios/drive.toml")
    tables["imu"]["track"] = str(ROOT / "docs/scenarios/drive.csv")
    return tables


def kinds(folder: Path, campaign: dict[str, Any], fixtures: dict[str, Any]) -> dict[str, Kind]:
    """Return all kinds; ``campaign`` of a folder that lies in ``folder``, ``fixtures`` as exported."""
    laboratory = tomllib.loads(EXAMPLE.read_text()) | {
        "item": {"received": date(2026, 3, 2), "condition": "no damage"}
    }
    limits = ("fixtures", "limits", "FOG-3", "--db", str(folder / "hostile.db"), "--import")
    effect = _command("effects", "add", after=("--model", "FOG-3"), database=folder / "empty.db")

    def solve(path: Path) -> int:
        return cli.run(["solve", str(path.parent), "--json", str(folder / "o.json")])

    scenario = partial(Kind, "scenario.toml", take=_by(read_scenario))
    return {
        "campaign": Kind("campaign.toml", campaign, solve),
        "plan": Kind("plan.toml", tomllib.loads(PLAN), _by(lambda path: (read_plan(path), read_mounting(path)))),
        "limits": Kind("limits.toml", tomllib.loads(example_limits("FOG-3")), _command(*limits)),
        "fixtures": Kind("fixtures.toml", fixtures, _command("fixtures", "import", database=folder / "empty.db")),
        "effect": Kind("effect.toml", tomllib.loads(DEAD_ZONE), effect),
        "lagging_effect": Kind("effect.toml", tomllib.loads(WARMING), effect),
        "laboratory": Kind("laboratory.toml", laboratory, _by(read_laboratory)),
        "faults": Kind("faults.toml", tomllib.loads(FAULTS), _by(lambda path: read_faults(path, is_on_can=True))),
        "scenario": scenario(_text("scenarios/troubles.toml")),
        "drive": scenario(_drive()),
        "calibration_scenario": scenario(_text("scenarios/calibration.toml")),
        "tolerance": Kind(
            "items.toml", tomllib.loads(ITEMS), _command("fixtures", "tolerance", "--cubes", "1000", "--items")
        ),
    }
