"""Which calibration is applied: of a file, of the database, of the maker, and what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.wire import FORMATS
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import accept_calibration
from procedures.calibration.solution_values import Estimate, Solution, TriadCalibration
from procedures.campaign.campaign import UNKNOWN
from procedures.errors import ErrorCode
from station.calibrated.calibration_choice import chosen_calibration, refuse_unfit
from station.errors import DataRefused
from station.stream.connected_unit import Unit
from tests.fixtures_db.factory import facts, solution
from tests.refusals import refused

COUNTS, RATES = FORMATS["counts"], FORMATS["kvh1750"]
S1 = Unit("FOG-3", "S1", 0.01)


def both_triads(bias: float) -> Solution:
    gyroscope = TriadCalibration(
        Estimate(np.full(3, 2000.0), np.full(3, 1e-3), "count/deg"),
        Estimate(np.eye(3), np.full((3, 3), 1e-6), "1"),
        Estimate(np.full(3, 0.5), np.full(3, 1e-2), "deg/h"),
    )
    return replace(solution(bias), gyroscope=gyroscope)


@pytest.fixture
def database(tmp_path: Path) -> str:
    path = str(tmp_path / "s.db")
    with open_db(path) as opened, opened.write() as session:
        for serial, bias in (("S1", 1e-3), ("S1", 3e-3), ("S2", 5e-3)):
            accept_calibration(session, both_triads(bias), facts(serial))
    return path


def bias_of(asked: str, database: str, unit: Unit = S1) -> float:
    document = chosen_calibration(asked, database, unit, COUNTS).document
    assert document is not None
    return float(document["accelerometer"]["bias"]["value"][0])


def test_the_newest_of_the_unit_is_taken_whether_it_is_named_or_not(database: str) -> None:
    assert bias_of("", database) == bias_of("S1", database) == 3e-3


def test_a_device_that_does_not_say_who_it_is_needs_a_name(database: str) -> None:
    nobody = Unit(UNKNOWN, UNKNOWN, 0.01)
    assert bias_of("S2", database, nobody) == 5e-3
    with refused(DataRefused, ErrorCode.CALIBRATION):
        chosen_calibration("", database, nobody, COUNTS)


@pytest.mark.parametrize(
    ("asked", "unit", "reported"),
    [
        ("S2", S1, ("FOG-3 S2", "FOG-3 S1")),
        ("S1", Unit("FOG-4", "S1", 0.01), ("FOG-3 S1", "FOG-4 S1")),
        ("S9", S1, ("S9",)),
        ("", Unit("FOG-3", "S9", 0.01), ("FOG-3 S9",)),
    ],
)
def test_another_units_is_refused(asked: str, unit: Unit, reported: tuple[str, ...], database: str) -> None:
    with refused(DataRefused, ErrorCode.CALIBRATION, *reported):
        chosen_calibration(asked, database, unit, COUNTS)


def test_a_calibration_of_counts_is_not_applied_to_rates(database: str) -> None:
    with refused(DataRefused, ErrorCode.CALIBRATION, "kvh1750"):
        chosen_calibration("S1", database, S1, RATES)


def test_nominal_scales_are_taken_when_they_are_asked_for_and_not_else(database: str) -> None:
    unit = Unit("STIM300 10 g", "S9", 0.01)
    with refused(DataRefused, ErrorCode.CALIBRATION, "--nominal"):
        chosen_calibration("", database, unit, FORMATS["stim300"])
    found = chosen_calibration("", database, unit, FORMATS["stim300"], nominal=True)
    assert found.document is None
    assert found.nominal == FORMATS["stim300"].scales["STIM300 10 g"]
    with refused(DataRefused, ErrorCode.CALIBRATION, "FOG-3"):
        chosen_calibration("", database, S1, COUNTS, nominal=True)


def test_what_the_monitor_found_is_held_to_the_same(database: str) -> None:
    own = chosen_calibration("", database, S1, COUNTS)
    refuse_unfit(own, "--calibration", S1, COUNTS)
    with refused(DataRefused, ErrorCode.CALIBRATION):
        refuse_unfit(own, "--calibration", S1, RATES)
    with refused(DataRefused, ErrorCode.CALIBRATION):
        refuse_unfit(replace(own, document=None), "--calibration", S1, COUNTS)
