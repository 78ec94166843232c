"""`station monitor --locate --wheel` as a program: live over CAN, a recorded drive, and what becomes of it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.can.wheel_signal import wheel_signal
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.companions.wheel_on_can import (
    DBC,
    RATE_HZ,
    SIGNAL,
    SimulatedWheel,
    wheel_speeds,
    wheel_toml,
)
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.files.mcap_files.schemas import WHEEL_RAW_TOPIC
from station.stream.reader import Chunk
from station.stream.reader.raw_recording import RawRecording
from tests.drivers.simulated.drives import bends
from tests.station.commands.program import Program
from tests.station.monitor.driving import record_drive, stands_on
from tests.station.monitor.unit import write_calibration

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(40.0, still=11.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
SCALE, SECONDS, LATE = 1.015, 26.0, 0.01
BUS = "can://slcan/dev/ttyNONE?bitrate=500000"


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the recording of a drive with its wheel's, as a monitored run leaves it."""
    file = record_drive(tmp_path_factory.mktemp("drive") / "r", TRUTH, TRACK, AUTOPILOT, SECONDS)
    record_wheel(file.parent, LATE)
    return file


def record_wheel(folder: Path, late: float) -> None:
    """Write a wheel's recording, its frames read ``late`` [s]."""
    failures, signal = list[Exception](), wheel_signal(DBC, SIGNAL)
    recording = RawRecording(folder / "wheel_session_1.mcap", {}, failures.append, WHEEL_RAW_TOPIC)
    t = np.arange(0.0, SECONDS, 1 / RATE_HZ)
    for at, speed in zip(t, wheel_speeds(t, TRACK, SCALE, np.random.default_rng(1)), strict=True):
        recording.put(Chunk(round((at + late) * 1e9), signal.frame(float(speed), 0)))
    recording.close()
    assert not failures
    (folder / "wheel.toml").write_text(wheel_toml(BUS, "gone.dbc") + f"time_offset_s = {-late}\n")
    (folder / "wheel.dbc").write_bytes(Path(DBC).read_bytes())


def asked(folder: Path) -> list[str]:
    return ["--calibration", str(write_calibration(folder, TRUTH)), "--lever-arm", "0,0,0"]


@pytest.mark.proof
def test_a_recorded_drive_is_located_with_its_wheel_the_same_each_time(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replay = ["monitor", f"replay:{drive}", "--speed", "0", "--json", "--locate", *asked(tmp_path)]
    assert cli.run(replay) == 0
    reported = capsys.readouterr().out
    places = [json.loads(line)["location"] for line in reported.splitlines()]
    last = places[-1]
    assert stands_on(TRACK, last)
    scale, std = (float(each) for each in last["wheel"].removeprefix("scale ").split(" +- "))
    assert std < 0.01
    assert abs(scale - SCALE) < 3.5 * std + 5e-5
    assert cli.run(replay) == 0
    assert capsys.readouterr().out == reported


@pytest.mark.proof
def test_a_wheel_that_comes_too_late_to_be_used_is_reported(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for file in drive.parent.iterdir():
        if "wheel" not in file.name:
            (tmp_path / file.name).write_bytes(file.read_bytes())
    record_wheel(tmp_path, 0.6)
    replay = ["monitor", f"replay:{tmp_path / drive.name}", "--speed", "0", "--json", "--locate", *asked(tmp_path)]
    assert cli.run(replay) == 0
    last = json.loads(capsys.readouterr().out.splitlines()[-1])["location"]
    assert last["wheel"].startswith("its speeds arrive 0.6")
    assert stands_on(TRACK, last)  # nobody waited for it


def test_a_recorded_drive_becomes_a_folder_with_a_wheel(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "f"
    record = ["record", f"replay:{drive}?format=counts", "--fusion", str(folder), *asked(tmp_path)]
    assert cli.run(record) == 0
    assert "speeds of the wheel" in capsys.readouterr().out
    out = tmp_path / "location.json"
    assert cli.run(["locate", str(folder), "--json", str(out)]) == 0
    found = json.loads(out.read_text())["wheel"]
    assert abs(found["scale"] - SCALE) < 3.5 * found["scale_std"]
    t, speed = np.loadtxt(folder / "wheel.csv", delimiter=",", skiprows=1).T
    true = np.linalg.norm(TRACK.velocities(t), axis=1)
    assert np.abs(speed * SCALE - true).mean() < 0.05


def test_a_live_wheel_is_followed_and_recorded(tmp_path: Path) -> None:
    with (
        SimulatedDevice(TRUTH, 5, speed=3.0) as imu,
        SimulatedGnss(TRUTH, AUTOPILOT, track=TRACK, imu=imu) as gnss,
        SimulatedWheel(TRACK, imu=imu) as wheel,
    ):
        (tmp_path / "axle.toml").write_text(wheel_toml(wheel.url, DBC))
        given = ["--plain", "--gnss", gnss.url, "--folder", str(tmp_path / "r"), *asked(tmp_path)]
        given += ["--locate", "--wheel", str(tmp_path / "axle.toml")]
        with Program("monitor", imu.url, *given) as program:
            program.until("wheel: it waits for position and heading")
            program.press("q")
            code, _, error = program.end()
    assert (code, error) == (0, "")
    assert len(list((tmp_path / "r").glob("wheel_session_*.mcap"))) == 1
    assert (tmp_path / "r" / "wheel.toml").read_bytes() == (tmp_path / "axle.toml").read_bytes()
    assert (tmp_path / "r" / "wheel.dbc").read_bytes() == Path(DBC).read_bytes()


@pytest.mark.parametrize(
    ("table", "code", "reported"),
    [
        (wheel_toml(BUS, DBC).replace("SPEED", "SPEEDS"), 3, "no signal 'SPEEDS' in WHEELS"),
        (wheel_toml(BUS, DBC).replace("SPEED", "COUNTER"), 3, "COUNTER without a unit; expected a unit of speed"),
        (wheel_toml(BUS, DBC) + 'unit = "rpm"\n', 3, "in 'rpm'; expected a unit of speed"),
        (wheel_toml(BUS, "none.dbc"), 3, "none.dbc"),
        (wheel_toml("serial:///dev/ttyUSB0", DBC), 3, "a DBC and a signal"),
        (wheel_toml(BUS, DBC, "[1, 1, 0]"), 3, "a direction of length 1"),
        (wheel_toml(BUS, DBC), 4, "ttyNONE"),
    ],
)
def test_a_wheel_that_is_wrong_or_not_there_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], table: str, code: int, reported: str
) -> None:
    (tmp_path / "axle.toml").write_text(table)
    with SimulatedDevice(TRUTH, 5) as imu, SimulatedGnss(TRUTH, AUTOPILOT, imu=imu) as gnss:
        wanted = ["monitor", imu.url, "--json", "--gnss", gnss.url, "--folder", str(tmp_path / "r"), "--locate"]
        assert cli.run([*wanted, *asked(tmp_path), "--wheel", str(tmp_path / "axle.toml")]) == code
    error = capsys.readouterr().err
    assert reported in error
    assert len(error.strip().splitlines()) == 1
