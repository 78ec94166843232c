"""Every command that reads a campaign names a dead channel: no traceback, no warning of a library, no exit 70."""

from dataclasses import replace
from pathlib import Path

import pytest

from station import cli
from tests.procedures.campaign.test_dead_channels import ACCEL, GYRO, Kill, dead, every_step, everywhere, recorded
from tests.station.campaign_writing import write_campaign

CASES: dict[str, tuple[Kill, str, int]] = {  # what is dead, what is said, exit code of measuring the cube
    "one gyroscope": (dead(GYRO, "yz", everywhere, 17.0), "gyroscope y outputs a constant 17", 0),
    "an accelerometer": (dead(ACCEL, "y", everywhere), "accelerometer y outputs a constant 0", 5),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("case", CASES)
def test_a_dead_channel_is_named(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kill, words, measured = CASES[case]
    campaign = every_step(replace(recorded(True), soaks=()), kill)
    folder, db = tmp_path / "c", ("--db", str(tmp_path / "s.db"))
    write_campaign(folder, replace(campaign, fixture=replace(campaign.fixture, id="CUBE-7")), 0.05)
    assert cli.run(["fixtures", "add", "cube", "CUBE-7", "--side-mm", "400", *db]) == 0
    for command in ("solve", "diagnose"):
        assert cli.run([command, str(folder), *db]) == 0
        assert words in " ".join(capsys.readouterr().out.split())
    assert cli.run(["report", str(folder), "--out", str(tmp_path / "r.html"), *db]) == 0
    assert words in (tmp_path / "r.html").read_text()
    capsys.readouterr()
    assert cli.run(["fixtures", "measure", "CUBE-7", str(folder), *db]) == measured
    assert (words in capsys.readouterr().err) == (measured == 5)
