"""A receiver's file back as it was written, its replay beside the IMU, and ticks that wait for its reader."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.earth.gnss_records import AirData, FixType, GnssFix, TimeMark
from station import cli
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.calibration_in_use import InUse
from station.errors import DataRefused
from station.files.mcap_files.fix_reader import read_fixes
from station.files.mcap_files.fix_writer import FixWriter
from station.monitor import monitor, readers_beside
from station.monitor.monitor import MonitorOptions
from station.stream.replay.gnss import recorded_choice, recorded_gnss
from tests.drivers.simulated.drives import bends
from tests.station.monitor.driving import Receiver, open_feed, record_drive
from tests.station.monitor.unit import calibration_of, write_calibration
from tests.station.stream.live.bench_in_memory import Source

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5)
RECORDS = [
    GnssFix("GPS_RAW_INT", 1, 10**18 + 7, FixType.RTK_FIXED, latitude=0.1234567890123, longitude=-0.0, speed=0.0),
    TimeMark(10**18 + 8, 5, None),
    TimeMark(10**18 + 9, 6, 10**18),
    AirData(10**18 + 10, 12.25),
    GnssFix("GLOBAL_POSITION_INT", 1, 10**18 + 11, FixType.NO_FIX, satellites=0, is_filtered=True),
]


def write(path: Path) -> Path:
    writer = FixWriter(path)
    for record in RECORDS:
        writer.write(record)
    writer.close()
    return path


def test_records_come_back_as_they_were_the_unknown_still_unknown(tmp_path: Path) -> None:
    assert read_fixes(write(tmp_path / "gnss_1.mcap")) == RECORDS


def test_a_file_cut_short_is_read_as_far_as_it_goes_and_a_damaged_one_refused(tmp_path: Path) -> None:
    whole = write(tmp_path / "gnss_1.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) * 3 // 4])
    assert read_fixes(tmp_path / "cut.mcap") in ([], RECORDS)
    at = whole.index(b"zstd") + 20
    (tmp_path / "bad.mcap").write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
    with pytest.raises(DataRefused, match="damage after record 0"):
        read_fixes(tmp_path / "bad.mcap")


def test_an_airspeed_is_replayed_and_the_aid_that_the_run_had_is_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = record_drive(tmp_path / "r", TRUTH, bends(20.0), AutopilotTruth(airspeed_m_s=7.5, default_hz=5.0), 12.0)
    replay = ["monitor", f"replay:{file}", "--speed", "0", "--json"]
    replay += ["--calibration", str(write_calibration(tmp_path, TRUTH))]
    assert recorded_choice(file, "aid") == ""
    (tmp_path / "r" / "events.csv").write_text("utc,device_s,sample,event,text\n,0,0,aid,airspeed-filter\n")
    for more, aid in (([], "airspeed-filter"), (["--aid", "gnss"], "gnss"), (["--aid", "none"], "none")):
        assert cli.run([*replay, *more]) == 0
        last = json.loads(capsys.readouterr().out.splitlines()[-1])
        assert last["aid"] == aid
        if aid == "airspeed-filter":
            assert last["speed_m_s"] == 7.5
        else:
            assert last.get("speed_m_s", 0.0) != 7.5
    (tmp_path / "r" / "events.csv").write_bytes(b"utc,event\n\xff\xfe\n")
    assert cli.run(replay) == 3


class Lagging(Receiver):
    """A receiver whose reader has told nothing of the last while."""

    limit_ns = 0

    @property
    def up_to_ns(self) -> int:
        return self.limit_ns


def test_a_tick_waits_for_what_the_receivers_reader_may_still_tell_but_not_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(readers_beside, "monotonic", lambda: now[0])
    source = Source(TRUTH)
    feed = open_feed(source)
    feed.identify()
    heard = Autopilot(TRUTH, AutopilotTruth(default_hz=5.0))
    receiver = Lagging(source, heard, None, lambda t: 0.0, GnssFix | TimeMark)
    applied = AppliedCalibration(calibration_of(TRUTH), None, InUse("by hand"))
    engine = monitor.Monitor(feed, applied, MonitorOptions(aid="gnss"), None, receiver)
    for _ in range(10):
        engine.round()
    assert engine.view.line == "waiting for the first samples"
    receiver.limit_ns = round(5.0 * 1e9)
    engine.round()
    assert engine.view.reading is not None
    assert 4.7 < engine.view.reading.t <= 5.0
    now[0] += 0.06
    engine.round()
    assert engine.view.reading.t <= 5.0
    now[0] += 0.06
    engine.round()
    assert engine.view.reading.t > 5.0


def test_its_rate_is_that_of_a_receivers_own_fixes_and_of_no_filters(tmp_path: Path) -> None:
    writer = FixWriter(tmp_path / "gnss_1.mcap")
    for record in (*RECORDS, replace(RECORDS[0], host_ns=10**18 + 12)):
        writer.write(record)
    writer.close()
    replayed = recorded_gnss(tmp_path / "imu.mcap")
    assert replayed is not None
    assert len(replayed.take(2 * 10**18)) == len(RECORDS) + 1
    assert replayed.stream().samples == 2
