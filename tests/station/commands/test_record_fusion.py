"""`station record --fusion`: a drive on one truth made a fusion folder and located; live; what it refuses."""

import json
import signal
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.files.fusion_folder import read_fusion
from station.files.mcap_files import read_step
from station.files.mcap_files.gnss_file import Record, read_fixes
from tests.drivers.simulated.drives import bends
from tests.patience import paced
from tests.station.commands.program import Program
from tests.station.monitor.driving import record_drive
from tests.station.monitor.unit import write_calibration

TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, default_hz=5.0)
TRACK = bends(60.0, 20.0)


@pytest.mark.proof
def test_a_drive_is_made_a_folder_and_located_where_it_was(tmp_path: Path) -> None:
    file = record_drive(tmp_path / "r", TRUTH, TRACK, AUTOPILOT, 45.0)
    calibration = ["--calibration", str(write_calibration(tmp_path, TRUTH))]
    folder = tmp_path / "fusion"
    asked = ["--fusion", str(folder), "--lever-arm", "0,0,0", *calibration]
    assert cli.run(["record", f"replay:{file}", *asked]) == 0
    log = read_fusion(folder)
    assert log.imu is not None
    assert log.noise is not None
    device = read_step(file).device_ns / 1e9
    assert log.imu.t == pytest.approx(device - 0.01)  # the middle of each interval
    first = TRACK.position(float(log.fixes.t[0]))
    off = log.fixes.p_n - TRACK.positions(log.fixes.t) + first
    assert np.linalg.norm(off, axis=1).max() < 8 * 0.3  # the receiver's own error and the first fix's, up too
    v_off = log.fixes.v_n[:, :2] - TRACK.velocities(log.fixes.t)[:, :2]
    assert np.sqrt(np.mean(v_off**2)) == pytest.approx(0.05, rel=0.2)  # its noise: the times are right
    # white: 1e-4 deg/sqrt(s) and 1e-5 g in 20 ms; the counting is next to it
    assert 0.7 < log.noise.gyro / np.radians(1e-4) < 1.5
    assert log.noise.accel < 8e-3
    _located(folder, tmp_path, first)


def _located(folder: Path, tmp_path: Path, first: np.ndarray) -> None:
    out, json_file = tmp_path / "t.tum", tmp_path / "j.json"
    assert cli.run(["locate", str(folder), "--out", str(out), "--json", str(json_file)]) == 0
    poses = np.loadtxt(out)
    off = poses[:, 1:4] - TRACK.positions(poses[:, 0]) + first
    assert np.median(np.linalg.norm(off, axis=1)) < 2.0  # the receiver's own error wanders by 0.3 m and 0.5 m up
    v = TRACK.velocities(poses[:, 0])
    ahead = Rotation.from_quat(poses[:, 4:]).apply([1.0, 0, 0])
    yaw = np.degrees(np.arctan2(ahead[:, 1], ahead[:, 0]) - np.arctan2(v[:, 1], v[:, 0]))
    reported = json.loads(json_file.read_text())
    assert np.median(np.abs((yaw + 180) % 360 - 180)) < 0.5
    assert abs(reported["time_offset_s"]) < 3 * 0.02
    assert reported["rejected_fixes"] == 0


def test_a_live_run_that_ctrl_c_ends_leaves_the_folder_that_its_recording_gives(tmp_path: Path) -> None:
    calibration = ["--calibration", str(write_calibration(tmp_path, TRUTH))]
    with SimulatedDevice(TRUTH, 5, speed=paced(10.0)) as imu, SimulatedGnss(TRUTH, AUTOPILOT, imu=imu) as gnss:
        given = ["--gnss", gnss.url, "--out", str(tmp_path / "r"), "--fusion", str(tmp_path / "one")]
        with Program("record", imu.url, *given, *calibration) as program:
            while len(recorded(tmp_path / "r")) < 60:
                Event().wait(0.05)
            program.process.send_signal(signal.SIGINT)
            code, out, _ = program.end()
    assert code == 130
    assert f"station locate {tmp_path / 'one'}" in out
    url = f"replay:{tmp_path / 'r' / 'recording.mcap'}"
    assert cli.run(["record", url, "--fusion", str(tmp_path / "two"), *calibration]) == 0
    for name in ("fusion.toml", "imu.csv", "gnss.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    log = read_fusion(tmp_path / "one")
    assert log.table.gnss.lever_arm_m is None
    assert log.table.site.latitude_deg == pytest.approx(48.1, abs=1e-4)


def recorded(folder: Path) -> list[Record]:
    return [one for file in folder.glob("gnss_2*.mcap") if file.stat().st_size > 8 for one in read_fixes(file)]
