"""`station record --fusion`: a drive on one truth, recorded, made a fusion folder and located."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.gnss_server import SimulatedGnss
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.fusion_folder import read_fusion
from tests.drivers.simulated.drives import bends
from tests.station.monitor.unit import write_calibration

SPEED, SECONDS, STILL = 15.0, 90.0, 45.0
TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
TRACK = bends(SECONDS, STILL)
AUTOPILOT = AutopilotTruth(position_std_m=0.3, velocity_std_m_s=0.05)


def record(tmp_path: Path, *more: str) -> int:
    calibration = str(write_calibration(tmp_path, TRUTH))
    with SimulatedDevice(TRUTH, 5, speed=SPEED, hold=True) as imu:
        imu.device.drive(TRACK)
        with SimulatedGnss(TRUTH, AUTOPILOT, track=TRACK, beside=imu) as gnss:
            imu._go.set()  # noqa: SLF001
            given = ["--gnss", f"{gnss.url}?rate=10", "--out", str(tmp_path / "r"), "--seconds", str(SECONDS - 20)]
            return cli.run(["record", imu.url, *given, "--calibration", calibration, *more])


def test_a_drive_is_recorded_and_located_where_it_was(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "fusion"
    assert record(tmp_path, "--fusion", str(folder), "--lever-arm", "0,0,0") == 0
    said = capsys.readouterr().out
    assert "s of rest" in said
    log = read_fusion(folder)
    assert log.imu is not None
    assert log.noise is not None
    off = log.fixes.p_n - TRACK.positions(log.fixes.t) + TRACK.position(float(log.fixes.t[0]))
    assert np.median(np.linalg.norm(off, axis=1)) < 4.0
    # white: 1e-4 deg/sqrt(s) and 1e-5 g in 20 ms; the counting is beside it
    assert 0.7 < log.noise.gyro / np.radians(1e-4) < 1.5
    assert log.noise.accel < 8e-3
    url, two = f"replay:{tmp_path / 'r' / 'recording.mcap'}", tmp_path / "two"
    again = ["--fusion", str(two), "--lever-arm", "0,0,0", "--calibration", str(tmp_path / "calibration.json")]
    assert cli.run(["record", url, *again]) == 0
    for name in ("fusion.toml", "imu.csv", "gnss.csv"):
        assert (folder / name).read_bytes() == (two / name).read_bytes()
    pytest.importorskip("gtsam", reason="gtsam is not installed: `make locate`")
    _located(folder, tmp_path, TRACK.position(float(log.fixes.t[0])))


def _located(folder: Path, tmp_path: Path, origin: np.ndarray) -> None:
    out, told = tmp_path / "t.tum", tmp_path / "j.json"
    assert cli.run(["locate", str(folder), "--out", str(out), "--json", str(told)]) == 0
    poses = np.loadtxt(out)
    off = poses[:, 1:4] - TRACK.positions(poses[:, 0]) + origin
    assert np.median(np.linalg.norm(off, axis=1)) < 2.0  # the receiver's own error wanders by 0.3 m and 0.5 m up
    v = TRACK.velocities(poses[:, 0])
    ahead = Rotation.from_quat(poses[:, 4:]).apply([1.0, 0, 0])
    yaw = np.degrees(np.arctan2(ahead[:, 1], ahead[:, 0]) - np.arctan2(v[:, 1], v[:, 0]))
    said = json.loads(told.read_text())
    assert np.median(np.abs((yaw + 180) % 360 - 180)) < 3 * said["alignment"]["std"]["yaw_deg"]
    assert abs(said["time_offset_s"]) < 3 * 0.02
    assert said["rejected_fixes"] == 0


def test_without_fixes_or_a_place_to_write_to_it_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibration = str(write_calibration(tmp_path, TRUTH))
    with SimulatedDevice(TRUTH, 5, speed=SPEED) as imu:
        fusion = ["--fusion", str(tmp_path / "f"), "--calibration", calibration]
        assert cli.run(["record", imu.url, *fusion]) == 2
        assert cli.run(["record", imu.url, *fusion, "--out", str(tmp_path / "q"), "--lever-arm", "1;2"]) == 2
        assert cli.run(["record", imu.url, *fusion, "--out", str(tmp_path / "r"), "--seconds", "5"]) == 3
    told = capsys.readouterr().err.splitlines()
    assert [line for line in told if "--out" in line]
    assert [line for line in told if "X,Y,Z" in line]
    assert "0 fixes with a place" in told[-1]
    assert not (tmp_path / "f").exists()
    assert (tmp_path / "r" / "recording.mcap").exists()
