"""`station monitor --locate --camera` as a program: live over HTTP, a recorded drive, and what becomes of it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.companions.camera_server import CameraImages, SimulatedCamera
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth, CameraTruth, camera_toml
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC
from station.stream.reader import Chunk
from station.stream.reader.raw_recording import RawRecording
from tests.drivers.simulated.drives import bends
from tests.station.commands.program import Program
from tests.station.monitor.driving import record_drive, stands_on
from tests.station.monitor.unit import write_calibration

pytest.importorskip("cv2", reason="opencv is not installed: the extra `camera`")
TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(30.0, still=11.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
CAMERA = CameraTruth(rate_hz=10.0)
SMALL = CameraTruth(width=160, height=120, fx=100.0, fy=100.0, cx=79.5, cy=59.5, rate_hz=5.0)
ON, OFF = 9.0, 17.0  # s, when the camera is switched on, and when all ends
REPORTED = f"time_offset_s = {-CAMERA.latency_s}\n"


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the recording of a drive with its camera's, as a monitored run leaves it."""
    file = record_drive(tmp_path_factory.mktemp("drive") / "r", TRUTH, TRACK, AUTOPILOT, OFF)
    images, failures = CameraImages(TRUTH, CAMERA, (), TRACK, 1), list[Exception]()
    recording = RawRecording(file.parent / "camera_session_1.mcap", {}, failures.append, CAMERA_RAW_TOPIC)
    for t in np.arange(ON, OFF, 1 / CAMERA.rate_hz).tolist():
        recording.put(Chunk(round((t + CAMERA.latency_s) * 1e9), images.part(t)))
    recording.close()
    assert not failures
    (file.parent / "camera.toml").write_text(camera_toml(CAMERA, "camera:http://127.0.0.1:1/stream") + REPORTED)
    return file


def asked(folder: Path) -> list[str]:
    return ["--calibration", str(write_calibration(folder, TRUTH)), "--lever-arm", "0,0,0"]


@pytest.mark.proof
def test_a_recorded_drive_is_located_by_its_images_the_same_each_time(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replay = ["monitor", f"replay:{drive}", "--speed", "0", "--json", "--locate", *asked(tmp_path)]
    assert cli.run(replay) == 0
    reported = capsys.readouterr().out
    located = [
        place for line in reported.splitlines() if (place := json.loads(line)["location"])["state"] == "located"
    ]
    assert located[0]["t_s"] < 14.0  # by IMU alone it takes 6 s of motion more
    last = located[-1]
    assert "features, stamps 40 ms late" in last["camera"]
    assert stands_on(TRACK, last)
    assert cli.run(replay) == 0
    assert capsys.readouterr().out == reported


@pytest.mark.proof
def test_a_recorded_drive_becomes_a_folder_with_tracks(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "f"
    record = ["record", f"replay:{drive}?format=counts", "--fusion", str(folder), *asked(tmp_path)]
    assert cli.run(record) == 0
    reported = capsys.readouterr().out
    assert f"{round((OFF - ON) * CAMERA.rate_hz)} frames of the camera" in reported
    assert f"station locate {folder} --source vision" in reported
    out = tmp_path / "location.json"
    assert cli.run(["locate", str(folder), "--source", "vision", "--json", str(out)]) == 0
    found = json.loads(out.read_text())
    assert found["source"] == "vision"
    assert found["initialised_at_s"] < 14.5
    table = (folder / "fusion.toml").read_text()
    assert "time_offset_s = -0.04" in table
    description = drive.parent / "camera.toml"
    noticed = description.read_text()
    try:
        description.write_text(noticed.replace(REPORTED, ""))
        assert cli.run([*record[:3], str(tmp_path / "untold"), *record[4:]]) == 0
    finally:
        description.write_text(noticed)
    assert "time_offset_std_s = 0.1" in (tmp_path / "untold" / "fusion.toml").read_text()


def test_live_images_are_followed_and_recorded(tmp_path: Path) -> None:
    with (
        SimulatedDevice(TRUTH, 5, speed=3.0) as imu,
        SimulatedGnss(TRUTH, AUTOPILOT, imu=imu) as gnss,
        SimulatedCamera(TRUTH, SMALL, imu=imu) as camera,
    ):
        (tmp_path / "eye.toml").write_text(camera_toml(SMALL, camera.url))
        given = ["--plain", "--gnss", gnss.url, "--folder", str(tmp_path / "r"), *asked(tmp_path)]
        given += ["--locate", "--camera", str(tmp_path / "eye.toml")]
        with Program("monitor", imu.url, *given) as program:
            program.until("camera: its delay is not known")
            program.press("q")
            code, _, error = program.end()
    assert (code, error) == (0, "")
    assert len(list((tmp_path / "r").glob("camera_session_*.mcap"))) == 1
    assert (tmp_path / "r" / "camera.toml").read_bytes() == (tmp_path / "eye.toml").read_bytes()


def test_a_camera_that_is_wrong_or_not_there_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    eye, folder = tmp_path / "eye.toml", ["--folder", str(tmp_path / "r")]
    wanted = ["monitor", "serial:///dev/ttyNONE?format=counts", "--json", "--gnss", "mavlink:udpin:127.0.0.1:0"]
    assert cli.run([*wanted, *folder, "--camera", str(eye)]) == 2
    assert "give --locate" in capsys.readouterr().err
    assert cli.run([*wanted, *folder, "--locate", "--camera", str(eye)]) == 3
    assert "no readable file" in capsys.readouterr().err
    with SimulatedDevice(TRUTH, 5) as imu, SimulatedGnss(TRUTH, AUTOPILOT, imu=imu) as gnss:
        eye.write_text(camera_toml(CAMERA, "camera:http://127.0.0.1:1/stream"))
        there = ["monitor", imu.url, "--json", "--gnss", gnss.url, "--seconds", "1", *folder, *asked(tmp_path)]
        assert cli.run([*there, "--locate", "--camera", str(eye)]) == 4
    assert "127.0.0.1:1" in capsys.readouterr().err
