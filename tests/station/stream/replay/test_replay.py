"""A recorded IMU at the pace that is asked for, and a receiver's file back as it was written."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.errors import PortNotFound, ReplayEnded
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.errors import ErrorCode
from procedures.gnss_records import AirData, FixType, GnssFix, TimeMark
from station import cli
from station.errors import DataRefused
from station.files.mcap_files import StepWriter
from station.files.mcap_files.gnss_file import FixWriter, read_fixes
from station.stream import replay
from station.stream.reader import Chunk
from station.stream.replay import Replay, recorded_choice
from tests.drivers.simulated.drives import bends
from tests.refusals import refused
from tests.station.monitor.driving import record_drive
from tests.station.monitor.unit import write_calibration

CHUNKS = [(5_000_000_000, b"first"), (5_100_000_000, b"second"), (5_400_000_000, b"last")]


class Clock:
    """Time that passes only in `sleep`."""

    def __init__(self) -> None:
        self.now, self.slept = 100.0, list[float]()

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(replay, "time", made)
    return made


@pytest.fixture
def url(tmp_path: Path) -> str:
    writer = StepWriter(tmp_path / "a.mcap")
    for host_ns, data in CHUNKS:
        writer.write_raw(host_ns, data)
    writer.close()
    return f"replay:{tmp_path / 'a.mcap'}"


def polled(replay: Replay, timeout_s: float) -> list[bytes]:
    return [each.data for each in replay.poll(timeout_s) if isinstance(each, Chunk)]


def test_at_full_speed_each_chunk_is_given_once_and_then_it_ends(url: str) -> None:
    replay = Replay(url, 0.0)
    given = [replay.poll(1.0) for _ in CHUNKS]
    assert given == [[Chunk(host_ns, data)] for host_ns, data in CHUNKS]
    with refused(ReplayEnded, None, "15"):  # bytes
        replay.poll(1.0)


@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_at_a_pace_chunks_come_when_they_are_due(url: str, clock: Clock, speed: float) -> None:
    replay = Replay(url, speed)
    assert polled(replay, 1.0) == [b"first"]
    assert clock.slept == []
    assert polled(replay, 0.04) == []
    assert polled(replay, 1.0) == [b"second"]
    assert sum(clock.slept) == pytest.approx(0.1 / speed)
    clock.now += 10.0
    assert polled(replay, 0.0) == [b"last"]


def test_a_file_without_bytes_of_a_device_is_no_source(tmp_path: Path) -> None:
    StepWriter(tmp_path / "a.mcap").close()
    with pytest.raises(PortNotFound):
        Replay(f"replay:{tmp_path / 'a.mcap'}")


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
