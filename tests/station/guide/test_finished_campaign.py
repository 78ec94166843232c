"""A campaign that is complete but not stored is gone on with for its verdict, whether or not its IMU is there."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from fixtures_db.database import Database
from fixtures_db.stored_calibrations import history
from procedures.campaign.plan_steps import Dwell, turn_steps
from station.files.campaign_folder.campaign_schema import read_campaign_toml
from station.files.campaign_folder.plan_file import keep_plan, write_note
from station.files.campaign_setup import Setup
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions
from station.guide.view import OperatorCommand
from station.results.contradictory_dwells import kept_tilt_warning
from tests.empty_database import empty_db
from tests.station.guide.stored import recorded

NOWHERE = "serial:///dev/ttyNONE?format=counts"
POSITIONS = tuple(Dwell(position, 4.0) for position in range(1, 13))


@pytest.fixture
def database(tmp_path: Path) -> Iterator[Database]:
    with empty_db(tmp_path / "s.db") as opened:
        yield opened


@pytest.fixture
def folder(tmp_path: Path, database: Database) -> Path:
    made = recorded(tmp_path / "c", database)
    keep_plan(made, POSITIONS)
    write_note(made, Setup(url=NOWHERE, latitude_deg=31.17))
    return made


def kept_tilted(folder: Path, position: int, *off: float) -> None:
    """Have it said that the cube was kept as it sat, so far off [rad]."""
    toml, found = folder / "campaign.toml", f"position = {position}\n"
    text = toml.read_text()
    assert text.count(found) == 1
    toml.write_text(text.replace(found, f"{found}kept_seat_rad = [{off[0]}, {off[1]}]\n"))


def resumed(folder: Path, database: Database, url: str = "") -> CalibrationEngine:
    engine = CalibrationEngine(
        database, CalibrationOptions(folder.parent, Setup(url=url), warms_up=False), lambda view: None
    )
    engine.execute(OperatorCommand(verb="resume", folder=str(folder)))
    engine.round()
    return engine


def test_it_goes_to_the_verdict_without_its_port_and_can_be_stored(folder: Path, database: Database) -> None:
    engine = resumed(folder, database)
    assert engine.view.stage == "verdict"
    assert (engine.view.unit, engine.view.done) == ("SIM-FOG3 SIM-7", 12)
    assert engine.view.verdict.diagnosis_text
    assert not engine.is_busy
    engine.execute(OperatorCommand(verb="redo", step="dwell_03"))
    assert engine.view.stage == "verdict"
    assert "/dev/ttyNONE" in engine.view.events[-1].text  # refused, and nothing changed
    engine.execute(OperatorCommand(verb="store"))
    assert engine.view.stage == "stored"
    engine.close()
    with database.read() as session:
        assert len(history(session, "SIM-7")) == 1


def test_a_seat_that_spoils_the_calibration_is_the_first_thing_a_verdict_says(
    folder: Path, database: Database
) -> None:
    kept_tilted(folder, 8, 0.0, -5e-4)  # as a cube's own face may be
    assert kept_tilt_warning(read_campaign_toml(folder)[0]) == ""
    kept_tilted(folder, 4, 5.2e-3, 0.0)
    engine = resumed(folder, database)
    verdict = engine.view.verdict
    assert verdict.doubt.startswith("do not use this result, record position 4 again: ")
    assert "tilted by 0.3 deg" in verdict.doubt
    assert f": {verdict.doubt}. " in verdict.sentence
    assert verdict.redo == "dwell_04"
    assert "do not use this result, record position 4 again" in Path(verdict.report).read_text(encoding="utf-8")
    engine.close()


def test_one_step_short_it_wants_its_port(folder: Path, database: Database) -> None:
    keep_plan(folder, (*POSITIONS, *turn_steps(1, 5.0)))
    engine = resumed(folder, database)
    assert engine.view.stage == "start"
    assert "no such port" in engine.view.start.refused
    assert "`station resume --device URL`" in engine.view.start.refused
    assert engine.view.start.setup.url == NOWHERE
    engine.close()
