"""What the first screen waits for: no numerics, no files of campaigns, no plots. Each of these took seconds."""

import subprocess
import sys

from station.commands.command_table import COMMANDS

NUMERICS = ("numpy", "scipy", "numba", "matplotlib", "procedures.campaign.plan_steps")
HEAVY = (*NUMERICS, "mcap", "google.protobuf", "alembic", "jinja2")
NOT_OF_A_SCREEN = (*HEAVY, "sqlalchemy", "serial", "fixtures_db.database", "fixtures_db.schema")
FORM = """
import sys, pathlib, station.cli
from station.commands.calibrate import calibrate
from station.commands._guided import set_up, campaigns_root
from station.guide.options import load_setup
from station.guide.client import engine_process
from station.guide.options import EngineOptions
from station.guide.client import EngineConnection
from station.tui.app import StationApp
from station.tui.screens import screen_for
set_up(load_setup(), {})
EngineOptions(root=campaigns_root()).engine()
screen_for("start")(print), screen_for("connecting")(print)
"""
ENGINE = """
import sys, pathlib
from station.guide import server
from station.guide.engine import CalibrationEngine
from station.guide.options import EngineOptions
from fixtures_db.database import open_db
with open_db(sys.argv[1]) as database:
    engine = CalibrationEngine(database, EngineOptions(root=pathlib.Path(".")).engine(), print)
    assert engine.view.start.setup is not None
    engine.close()
"""


def imported(program: str, *arguments: str) -> set[str]:
    """Return the modules that a program of its own has imported at its end."""
    command = [sys.executable, "-P", "-c", f"{program}\nprint(*sys.modules, sep='\\n')", *arguments]
    return set(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())


def test_the_form_is_drawn_without_numerics_and_without_a_database() -> None:
    assert sorted(imported(FORM) & set(NOT_OF_A_SCREEN)) == []


def test_the_engine_offers_the_form_without_numerics(tmp_path: object) -> None:
    imported(ENGINE, f"{tmp_path}/s.db")  # makes the database, which takes alembic
    assert sorted(imported(ENGINE, f"{tmp_path}/s.db") & set(HEAVY)) == []


def test_every_command_explains_itself_without_numerics() -> None:
    names = [command.name for command in COMMANDS]
    program = f"from station.cli import run\nimport sys\nfor name in {names}: assert run([name, '--help']) == 0"
    assert sorted(imported(program) & set(HEAVY)) == []


def test_a_solve_loads_no_compiler_and_nothing_that_it_does_not_need() -> None:
    program = "import sys, station.cli, station.commands.solve, station.files.campaign_folder.loaded_campaign\n"
    program += "import station.files.campaign_folder.campaign_reading, procedures.calibration.joint_calibration\n"
    program += "import station.results.solution_json, station.results.solution_text, station.files.atomic_file"
    found = imported(program)
    assert sorted(found & {"numba", "llvmlite"}) == []  # more than half of a whole solve
    # a third of what is left: optimisers and splines, the loop of a diagnosis with its catalogue
    others = ("optimize", "interpolate", "sparse", "spatial", "signal", "stats", "fft")
    assert sorted(found & {f"scipy.{each}" for each in others}) == []
    assert sorted(found & {*NOT_OF_A_SCREEN, "textual"} - set(NUMERICS)) == []
    assert [
        each for each in sorted(found) if each.startswith(("procedures.diagnosis", "procedures.effects"))
    ] == []
