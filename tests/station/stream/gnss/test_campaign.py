"""Whole programs with a GNSS receiver beside the IMU, both simulated, on one truth and one clock."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.autopilot_truth import EPOCH_UTC
from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.campaigns import campaign
from fixtures_db.database import open_db
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.mcap_files import read_step
from tests.patience import paced
from tests.station.commands.program import Program

SPEED = 60.0


@contextmanager
def bench(speed: float) -> Iterator[tuple[SimulatedDevice, SimulatedGnss]]:
    truth = replace(Truth.example(5), height_m=77.0, latitude_deg=31.17)
    with SimulatedDevice(truth, 5, speed=paced(speed)) as device:
        with SimulatedGnss(device.truth, beside=device) as gnss:
            yield device, gnss


def calibrate(device: SimulatedDevice, gnss: SimulatedGnss, folder: Path) -> tuple[str, ...]:
    short = ("--dwell-s", "10", "--turns", "1", "--move-s", "5", "--gravity", f"{device.truth.local_gravity:.7f}")
    where = ("--out", str(folder / "c"), "--db", str(folder / "s.db"))
    devices = ("--device", device.url, "--hands", device.control, "--gnss", f"{gnss.url}?rate=1")
    return ("calibrate", "--headless", *devices, *short, *where)


def test_a_campaign_takes_site_start_and_time_of_its_rows_from_gnss(tmp_path: Path) -> None:
    with bench(SPEED) as (device, gnss), Program(*calibrate(device, gnss, tmp_path)) as program:
        program.until("[2/19]")
        program.process.kill()
        program.end()
    loaded = read_campaign(tmp_path / "c")
    site, noted = loaded.tables.site, json.loads((tmp_path / "c" / "gnss.json").read_text())
    assert site.latitude_deg == pytest.approx(31.17, abs=4 * noted["horizontal_std_m"] / 111e3)
    assert site.height_m == pytest.approx(77.0, abs=4 * noted["vertical_std_m"])
    assert noted["utc"] >= np.datetime64(int(EPOCH_UTC), "s").astype(str)
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        started = campaign(session, str((tmp_path / "c").resolve())).started_utc
    assert 0 <= started.timestamp() - EPOCH_UTC < 3600
    assert np.isfinite(loaded.campaign.dwells[0].series.extra["utc_s"]).any()


def test_a_recording_holds_device_host_and_gnss_time_side_by_side(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with bench(40.0) as (device, gnss):
        out = str(tmp_path / "r")
        assert cli.run(["record", device.url, "--gnss", gnss.url, "--seconds", "160", "--out", out]) == 0
    said = capsys.readouterr().out
    assert "system 1" in said
    assert re.search(r"31\.(169|170)\d+, 121\.(399|400)\d+ deg, \d+\.\d m, 1 sigma 1\.\d m", said)
    step = read_step(tmp_path / "r" / "recording.mcap")
    utc = step.aux["utc_s"]
    known = np.isfinite(utc)
    assert known.sum() > 20
    behind = (utc - EPOCH_UTC - step.device_ns / 1e9)[known]
    assert abs(np.median(behind)) < 40.0 * 0.05  # 50 ms of the host, 40 times as fast
    assert {path.name.split("_2")[0] for path in (tmp_path / "r").glob("gnss*")} == {"gnss", "gnss_session"}
