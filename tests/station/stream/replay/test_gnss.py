"""A receiver's file back as it was written, its replay beside the IMU, and ticks that wait for its reader."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.earth.gnss_records import AirData, FixType, GnssFix, TimeMark
from procedures.error_codes import ErrorCode
from station import cli
from station.errors import DataRefused
from station.files.mcap_files.fix_reader import read_fixes
from station.files.mcap_files.fix_writer import FixWriter
from station.stream.replay.gnss import recorded_choice
from tests.drivers.simulated.drives import bends
from tests.refusals import refused
from tests.station.monitor.driving import record_drive
from tests.station.monitor.unit import write_calibration

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
    with refused(DataRefused, ErrorCode.DATA, "bad.mcap"):
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
