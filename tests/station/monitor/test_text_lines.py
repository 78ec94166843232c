"""What lines of text and JSON say of a rest, and what is said where there is no calibration."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.wire import FORMATS
from fixtures_db.database import open_db
from procedures.campaign.campaign import UNKNOWN
from procedures.error_codes import ErrorCode
from station.calibrated.calibration_choice import find_calibration
from station.errors import DataRefused
from station.monitor.text_lines import json_line, reading_line
from station.stream.recorder.connected_unit import Unit
from tests.refusals import refused
from tests.station.monitor.views import BEHIND, LOCATED, RESTING


def test_what_a_drift_holds_of_the_earth_stands_beside_it() -> None:
    assert RESTING.at_rest is not None
    held = "drift holds the Earth's rate: no --latitude"
    view = replace(RESTING, at_rest=replace(RESTING.at_rest, earth=held))
    assert reading_line(view).endswith(f"deg/h ({held})")
    assert json.loads(json_line(view))["at_rest"]["earth"] == held


@pytest.mark.parametrize(
    ("unit", "said"), [(Unit(UNKNOWN, UNKNOWN, 0.02), "--model and --serial"), (Unit("FOG3", "7", 0.02), "FOG3 7")]
)
def test_without_calibration_and_scale_it_says_what_to_do(unit: Unit, said: str, tmp_path: Path) -> None:
    database = str(tmp_path / "s.db")
    with open_db(database), refused(DataRefused, ErrorCode.CALIBRATION, said):
        find_calibration(None, database, unit, FORMATS["counts"])
    with refused(DataRefused, None, "c.json"):
        find_calibration(tmp_path / "c.json", database, unit, FORMATS["counts"])


def test_a_location_that_lags_behind_is_said_to() -> None:
    assert reading_line(BEHIND).endswith("; 12 s behind")
    assert "behind" not in reading_line(LOCATED)
