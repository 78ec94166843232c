"""``station locate`` with a wheel: what is said of it."""

import json
from pathlib import Path

from station import cli
from station.locate.locate_folder import location_text
from tests.procedures.fusion.drives import SCALE, SLIPS, Drive
from tests.station.files.fusion_folder.drive_folders import write_drive


def test_a_folder_with_a_wheel_says_scale_slips_and_rests(tmp_path: Path) -> None:
    folder = write_drive(tmp_path / "drive", Drive(15.0, outage=None))
    assert cli.run(["locate", str(folder), "--layers", "1", "--json", str(tmp_path / "j.json")]) == 0
    document = json.loads((tmp_path / "j.json").read_text())
    said = document["wheel"]
    assert abs(said["scale"] - SCALE) < 3.5 * said["scale_std"]
    assert said["scale_std"] < 2e-3
    begin, end, _ = SLIPS[0]
    assert any(a < end and b > begin for a, b in said["slips_s"])
    assert said["at_rest_s"] > 0
    assert "wheel scale factor    1.0" in location_text(document, fixes=1)
