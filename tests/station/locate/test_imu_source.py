"""`station locate` by an IMU: a planted flight, a car of KITTI, a wheel."""

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from procedures.geodesy import earth_rate_n
from station import cli
from station.files.fusion_folder import read_tum
from station.locate.locate_folder import location_text
from tests.procedures.fusion.drives import SCALE, SLIPS, Drive
from tests.procedures.fusion.motions import GRAVITY, NO_LEVER, Eight
from tests.station.files.fusion_folder.drive_folders import TOML, write_drive, write_rows

GNSS_HEADER = "t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s"
RATE_HEADER = "t_s,wx_rad_s,wy_rad_s,wz_rad_s,fx_m_s2,fy_m_s2,fz_m_s2"


def write_flight(folder: Path, seconds: float, lever: np.ndarray = NO_LEVER, late: float = 0.0) -> Path:
    """Write the IMU, GNSS and truth of a flight, the antenna at ``lever`` [m] and stamped ``late`` [s]."""
    folder.mkdir()
    flight, rng = Eight(seconds), np.random.default_rng(1)
    text = TOML.replace("gravity_m_s2 = 9.8066", f"gravity_m_s2 = {GRAVITY}")
    (folder / "fusion.toml").write_text(text.replace('[odometry]\nfile = "odometry.tum"\n', ""))
    imu, fixes = flight.imu(rng, earth_rate_n(np.radians(47.4))), flight.fixes(rng, lever, late)
    t = np.arange(0.0, seconds, 0.05)
    write_rows(folder / "imu.csv", ",", np.c_[imu.t, imu.omega_b, imu.f_b], RATE_HEADER)
    write_rows(folder / "gnss.csv", ",", np.c_[fixes.t, fixes.p_n, fixes.v_n], GNSS_HEADER)
    write_rows(folder / "truth.tum", " ", np.c_[t, flight.p(t), flight.attitude(t).as_quat()])
    return folder


@pytest.mark.parametrize("layers", ["1", "2"])
def test_a_flight_is_located_by_its_imu(layers: str, tmp_path: Path) -> None:
    folder, out = write_flight(tmp_path / "log", 16.0), tmp_path / "t.tum"
    arguments = ["--layers", layers, "--out", str(out), "--json", str(tmp_path / "j.json")]
    assert cli.run(["locate", str(folder), *arguments]) == 0
    reported = json.loads((tmp_path / "j.json").read_text())
    assert reported["source"] == "inertial"
    assert reported["layers"] == int(layers)
    assert reported["error_m"]["online"]["mean"] < 0.1
    assert reported["error_m"]["batch"]["mean"] < 0.06
    assert reported["alignment"]["std"]["yaw_deg"] < 4.0
    assert abs(reported["gyro_bias_rad_s"][2] - 0.07) < 0.005
    assert np.diff(np.loadtxt(out)[:, 0]).max() < 0.1001


@pytest.mark.proof
def test_an_antenna_whose_place_and_delay_are_not_given_is_found(tmp_path: Path) -> None:
    layers = "2"
    lever = np.array([0.4, -0.2, 0.3])
    folder = write_flight(tmp_path / "log", 18.0, lever, late=0.12)
    text = (folder / "fusion.toml").read_text()
    (folder / "fusion.toml").write_text(text.replace("lever_arm_m = [0.0, 0.0, 0.0]", "time_offset_std_s = 0.2"))
    assert cli.run(["locate", str(folder), "--layers", layers, "--json", str(tmp_path / "j.json")]) == 0
    reported = json.loads((tmp_path / "j.json").read_text())
    assert np.abs(np.array(reported["lever_arm_m"]) - lever).max() < 0.3  # 3 sigma of so short a flight
    assert abs(reported["time_offset_s"] + 0.12) < 0.025
    assert reported["error_m"]["online"]["mean"] < 0.2
    assert reported["error_m"]["batch"]["mean"] < 0.15


@pytest.mark.proof
def test_speed_and_course_without_a_climb_are_enough(tmp_path: Path) -> None:
    layers = "2"
    folder = write_flight(tmp_path / "log", 20.0)
    rows = np.loadtxt(folder / "gnss.csv", delimiter=",", skiprows=1)
    write_rows(folder / "gnss.csv", ",", rows[:, :6], GNSS_HEADER.removesuffix(",vu_m_s"))
    assert cli.run(["locate", str(folder), "--layers", layers, "--json", str(tmp_path / "j.json")]) == 0
    reported = json.loads((tmp_path / "j.json").read_text())
    assert reported["error_m"]["online"]["mean"] < 0.12
    assert reported["layers"] == int(layers)


def test_a_car_with_every_other_fix_is_where_the_others_say(tmp_path: Path) -> None:
    if find_spec("gtsam") is None:
        pytest.skip("the recording lies in gtsam's wheel: `pip install --no-deps gtsam`")
    from tests.benchmarks.kitti import held_out, write_kitti

    held = write_kitti(tmp_path / "log", every=2, seconds=33.0)
    assert cli.run(["locate", str(tmp_path / "log"), "--batch", str(tmp_path / "b.tum")]) == 0
    off = held_out(read_tum(tmp_path, "b.tum", 1), held)
    assert len(off) >= 15
    assert off.mean() < 0.15


def test_a_folder_with_a_wheel_says_scale_slips_and_rests(tmp_path: Path) -> None:
    folder = write_drive(tmp_path / "drive", Drive(15.0, outage=None))
    assert cli.run(["locate", str(folder), "--layers", "1", "--json", str(tmp_path / "j.json")]) == 0
    document = json.loads((tmp_path / "j.json").read_text())
    reported = document["wheel"]
    assert abs(reported["scale"] - SCALE) < 3.5 * reported["scale_std"]
    assert reported["scale_std"] < 2e-3
    begin, end, _ = SLIPS[0]
    assert any(a < end and b > begin for a, b in reported["slips_s"])
    assert reported["at_rest_s"] > 0
    assert "wheel scale factor    1.0" in location_text(document, fixes=1)
