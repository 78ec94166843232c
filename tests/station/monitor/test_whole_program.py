"""`station monitor` over a pty: JSON against the truth, replay, MAVLink out and GNSS in, refusals, keys."""

import json
import socket
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink import mavutil

from drivers.simulated.bench_control import BenchControl
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.calibrated.output_frame import body_axes
from station.files.sha256sums import verify_folder
from station.monitor import auxiliary_inputs
from tests.patience import paced
from tests.station.commands.program import Program
from tests.station.monitor.unit import write_calibration

SPEED = 20.0
VELOCITY_STD = 0.5  # [m/s] of a fix, each axis
FLAT = replace(Truth.example(5), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))


def device(truth: Truth = FLAT, position: int = 9, **options: Any) -> SimulatedDevice:
    served = SimulatedDevice(truth, 5, hold=True, **{"speed": paced(SPEED), **options})
    served.device.execute(f"place {position} 1")
    served._go.set()  # noqa: SLF001
    return served


def lines_of(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_json_lines_agree_with_the_truth_and_the_replay_ends_in_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    same = ["--calibration", calibration, "--latitude", "31.17", "--json"]
    with device() as served:
        run = ["monitor", served.url, "--folder", str(tmp_path / "r"), "--seconds", "20", *same]
        assert cli.run(run) == 0
    live = lines_of(capsys.readouterr().out)
    settled = [line for line in live if line["t_s"] > live[0]["t_s"] + 10]
    assert len(settled) > 80
    for line in settled:
        assert line["format"] == "monitor/1"
        assert abs(line["roll_deg"]) < 3 * line["sigma_deg"]
        assert abs(line["pitch_deg"]) < 3 * line["sigma_deg"]
    assert settled[-1]["at_rest"]["calibrated"]["level_deg"] < settled[-1]["at_rest"]["nominal"]["level_deg"]
    assert verify_folder(tmp_path / "r") == ["recording.mcap"]
    (session,) = (tmp_path / "r").glob("session_*.mcap")
    for file in (tmp_path / "r" / "recording.mcap", session):
        assert cli.run(["monitor", f"replay:{file}", "--speed", "0", *same]) == 0
        again = lines_of(capsys.readouterr().out)
        assert again[: len(live)] == live


def test_attitude_is_sent_by_mavlink(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    heard = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=9)
    port = heard.port.getsockname()[1]
    with device(position=5) as served:
        out = ["--mavlink-out", f"udpout:127.0.0.1:{port}", "--folder", str(tmp_path / "r"), "--seconds", "12"]
        assert cli.run(["monitor", served.url, "--calibration", calibration, "--json", *out]) == 0
    lines = {round(line["t_s"] * 1e3): line for line in lines_of(capsys.readouterr().out)}
    received = [heard.recv_match(type="ATTITUDE")]
    while received[-1] is not None:
        received.append(heard.recv_match(type="ATTITUDE"))
    heard.close()
    attitude = received[-2]
    assert attitude.get_srcSystem() == 200
    last = lines[attitude.time_boot_ms]  # the newest may not have found room while nobody listened
    assert np.degrees(attitude.roll) == pytest.approx(last["roll_deg"], abs=1e-4)
    assert np.degrees(attitude.pitch) == pytest.approx(last["pitch_deg"], abs=1e-4)
    assert np.isnan(attitude.yaw)
    assert np.degrees([attitude.rollspeed, attitude.pitchspeed, attitude.yawspeed]) == pytest.approx(
        last["rate_deg_s"], abs=1e-4
    )


def test_a_receiver_aids_and_the_replay_with_its_file_ends_in_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(auxiliary_inputs, "MAX_HOLD_S", -1.0)  # s: no tick waits for the receiver's reader
    calibration = str(write_calibration(tmp_path, FLAT))
    same = ["--calibration", calibration, "--json"]
    speed = paced(SPEED)
    autopilot = SimulatedGnss(FLAT, AutopilotTruth(velocity_std_m_s=VELOCITY_STD), speed=speed)
    with device(speed=speed) as served, autopilot as gnss:
        given = ["--gnss", f"{gnss.url}?rate=20", "--folder", str(tmp_path / "r"), "--seconds", "25"]
        assert cli.run(["monitor", served.url, *same, *given]) == 0
    lines = lines_of(capsys.readouterr().out)
    assert {line["aid"] for line in lines} == {"gnss"}
    assert lines[-1]["speed_m_s"] < 4 * VELOCITY_STD  # of one fix: on a busy machine few come in time
    assert abs(lines[-1]["roll_deg"]) < 4 * lines[-1]["sigma_deg"]
    (session,) = (tmp_path / "r").glob("session_*.mcap")
    assert list((tmp_path / "r").glob("gnss_session_*.mcap"))
    for file in (tmp_path / "r" / "recording.mcap", session):
        assert cli.run(["monitor", f"replay:{file}", "--speed", "0", *same]) == 0
        assert lines_of(capsys.readouterr().out)[: len(lines)] == lines
    assert cli.run(["monitor", f"replay:{session}", "--speed", "0", "--aid", "none", *same]) == 0
    without = lines_of(capsys.readouterr().out)
    assert {line["aid"] for line in without} == {"none"}
    assert without[-1]["roll_deg"] != lines[-1]["roll_deg"]
    assert len({line["speed_m_s"] for line in lines if "speed_m_s" in line}) > 3


def test_lines_of_text_take_keys_and_say_alarms(tmp_path: Path) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    with device() as served:
        asked = ("--plain", "--calibration", calibration, "--folder", str(tmp_path / "r"), "--alarm", "roll=30")
        with Program("monitor", served.url, *asked) as program:
            assert program.until("at rest")[0].startswith("SIM-FOG3 SIM-5, calibration calibration.json of 2026")
            with BenchControl(served.control) as hands:
                hands.place(5, 10.0)
            program.until("ALARM roll")
            program.press("m")
            program.until("mark 1")
            program.press("z")
            program.until("zero at roll")
            program.press("q")
            code, _, error = program.end()
    assert (code, error) == (0, "")
    received = (tmp_path / "r" / "events.csv").read_text()
    assert all(f",{event}," in received for event in ("begin", "alarm", "mark", "zero"))


def test_a_pulled_plug_is_reported_and_gone_on_after(tmp_path: Path) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    asked = ("--plain", "--calibration", calibration, "--folder", str(tmp_path / "r"))
    with SimulatedDevice(FLAT, 5, speed=paced(SPEED), transport="tcp", port=port) as served:
        program = Program("monitor", served.url, *asked).__enter__()
        program.until("at rest")
    try:
        program.until("unplugged")
        with SimulatedDevice(FLAT, 5, speed=paced(SPEED), transport="tcp", port=port):
            program.until("data arrive again")
            program.until("at rest")
            program.press("q")
            assert program.end()[0] == 0
    finally:
        program.__exit__(None, None, None)


@pytest.mark.parametrize(
    ("arguments", "code", "reported"),
    [
        (["--alarm", "wind=3"], 2, "expected NAME=LIMIT"),
        (["--axes", "x,y,-z"], 2, "left-handed"),
        (["--axes", "x,-x,z"], 2, "names an axis twice"),
        (["--aid", "gnss"], 2, "give --gnss URL"),
        (["--aid", "wings"], 2, "expected one of none, gnss"),
        (["--plain"], 2, "--json and --plain"),
        (["--calibration", "/nowhere.json"], 3, "/nowhere.json"),
        ([], 3, "no calibration of SIM-FOG3 SIM-5"),
        (["--mavlink-out", "tcp:127.0.0.1:1", "--calibration", "C"], 2, "udpout:HOST:PORT"),
    ],
)
def test_what_is_wrong_is_reported_in_a_line_and_leaves_nothing_behind(
    arguments: list[str], code: int, reported: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    given = [calibration if word == "C" else word for word in arguments]
    where = ["--json", "--folder", str(tmp_path / "r"), "--db", str(tmp_path / "s.db")]
    with device() as served:
        url = served.url if code == 3 or "C" in arguments else "serial:///dev/ttyNONE"  # usage is looked at first
        assert cli.run(["monitor", url, *where, *given]) == code
    error = capsys.readouterr().err
    assert reported in error
    assert error.count("\n") == 1
    assert not (tmp_path / "r").exists()


def test_body_axes_turn_what_stands_on_its_side_level(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    calibration = str(write_calibration(tmp_path, FLAT))
    assert np.linalg.det(body_axes("y,-z,-x")) == pytest.approx(1.0)
    with device(position=1) as served:  # X up
        run = ["monitor", served.url, "--folder", str(tmp_path / "r"), "--seconds", "12", "--axes", "y,-z,-x"]
        assert cli.run([*run, "--calibration", calibration, "--json"]) == 0
    last = lines_of(capsys.readouterr().out)[-1]
    assert abs(last["roll_deg"]) < 3 * last["sigma_deg"]
    assert abs(last["pitch_deg"]) < 3 * last["sigma_deg"]
