"""What campaigns and recordings take from a receiver: site, start, time; and what they do without it."""

import json
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import EPOCH_UTC
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.campaigns import campaign
from fixtures_db.database import open_db
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_setup import Setup
from station.files.mcap_files import read_step
from station.guide.campaign import port_check
from station.guide.campaign.port_check import NoFix, reopen_receiver, setup_with_site, utc_now
from station.stream.gnss_feed import open_gnss
from tests.patience import paced
from tests.station.commands.program import Program

SPEED = 60.0


@contextmanager
def bench(speed: float) -> Iterator[tuple[SimulatedDevice, SimulatedGnss]]:
    truth = replace(Truth.example(5), height_m=77.0, latitude_deg=31.17)
    with SimulatedDevice(truth, 5, speed=paced(speed)) as device:
        with SimulatedGnss(device.truth, imu=device) as gnss:
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
    reported = capsys.readouterr().out
    assert "system 1" in reported
    assert re.search(r"31\.(169|170)\d+, 121\.(399|400)\d+ deg, \d+\.\d m, u 1\.\d m", reported)
    step = read_step(tmp_path / "r" / "recording.mcap")
    utc = step.aux["utc_s"]
    known = np.isfinite(utc)
    assert known.sum() > 20
    behind = (utc - EPOCH_UTC - step.device_ns / 1e9)[known]
    assert abs(np.median(behind)) < 40.0 * 0.05  # 50 ms of the host, 40 times as fast
    assert {path.name.split("_2")[0] for path in (tmp_path / "r").glob("gnss*")} == {"gnss", "gnss_session"}


TRUTH = Truth(latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)


def test_what_is_stated_stands_and_is_compared_and_the_rest_is_taken(tmp_path: Path) -> None:
    with SimulatedGnss(TRUTH, speed=20.0) as gnss, open_gnss(gnss.url, tmp_path) as feed:
        setup = setup_with_site(Setup(gnss=gnss.url, latitude_deg=48.3), feed, tmp_path)
        began = utc_now(feed)
    assert setup.latitude_deg == 48.3
    assert setup.longitude_deg == pytest.approx(11.5, abs=1e-4)
    assert setup.height_m == pytest.approx(520.0, abs=10.0)
    assert began is not None
    assert began.year == 2026
    noted = json.loads((tmp_path / "gnss.json").read_text())
    assert noted["latitude_deg"] == pytest.approx(48.1, abs=1e-4)
    assert noted["height_above"] == "ellipsoid"
    assert "latitude_deg 48.3 is stated, GNSS gives 48.1" in noted["warnings"][0]


def test_without_a_fix_a_site_that_nobody_states_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_check, "MAX_SITE_WAIT_S", 0.8)
    monkeypatch.setattr(port_check, "SHORT_WAIT_S", 0.2)
    with SimulatedGnss(TRUTH) as gnss, open_gnss(gnss.url, tmp_path) as feed:
        gnss.plant("no_fix", 1e6)
        stated = Setup(gnss=gnss.url, latitude_deg=48.1)
        assert setup_with_site(stated, feed, tmp_path) == stated
        with pytest.raises(NoFix):
            setup_with_site(Setup(gnss=gnss.url), feed, tmp_path)


def test_a_campaign_is_gone_on_with_although_its_receiver_is_gone(tmp_path: Path) -> None:
    with ExitStack() as stack:
        assert reopen_receiver(stack, Setup(), tmp_path) == (None, "")
        feed, reported = reopen_receiver(stack, Setup(gnss="mavlink:tcp:127.0.0.1:9"), tmp_path)
    assert feed is None
    assert "continuing without GNSS: 127.0.0.1:9" in reported
