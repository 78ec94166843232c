"""``station locate`` by an IMU: a planted flight through files."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from procedures.earth.gravity_and_rate import earth_rate_n
from station import cli
from tests.computed_once import known
from tests.procedures.fusion.motions import GRAVITY, NO_LEVER, Eight
from tests.station.files.fusion_folder.folders import TOML, write_rows

GNSS_HEADER = "t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s"
RATE_HEADER = "t_s,wx_rad_s,wy_rad_s,wz_rad_s,fx_m_s2,fy_m_s2,fz_m_s2"
LEVER, LATE = np.array([0.4, -0.2, 0.3]), 0.12  # m, s


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


def with_an_open_antenna(folder: Path) -> None:
    """Write a flight that leaves open where its antenna is and how late its fixes are stamped."""
    text = (write_flight(folder, 18.0, LEVER, LATE) / "fusion.toml").read_text()
    (folder / "fusion.toml").write_text(text.replace("lever_arm_m = [0.0, 0.0, 0.0]", "time_offset_std_s = 0.2"))


def without_climb(folder: Path) -> None:
    """Write a flight whose fixes have no vertical velocity."""
    rows = np.loadtxt(write_flight(folder, 20.0) / "gnss.csv", delimiter=",", skiprows=1)
    write_rows(folder / "gnss.csv", ",", rows[:, :6], GNSS_HEADER.removesuffix(",vu_m_s"))


FLIGHTS = {
    "whole": lambda folder: write_flight(folder, 16.0),
    "open": with_an_open_antenna,
    "level": without_climb,
}


@known
def located(flight: str, layers: str) -> tuple[dict[str, Any], np.ndarray]:
    """Return what ``--json`` says of a flight of `FLIGHTS`, and the times [s] of its poses."""
    with TemporaryDirectory() as name:
        folder, out, said = Path(name, "log"), Path(name, "t.tum"), Path(name, "j.json")
        FLIGHTS[flight](folder)
        asked = ["locate", str(folder), "--layers", layers, "--out", str(out), "--json", str(said)]
        assert cli.run(asked) == 0
        return json.loads(said.read_text()), np.loadtxt(out)[:, 0]


@pytest.mark.parametrize("layers", ["1", "2"])
def test_a_flight_is_located_by_its_imu(layers: str) -> None:
    said, t = located("whole", layers)
    assert said["source"] == "inertial"
    assert said["layers"] == int(layers)
    assert said["error_m"]["online"]["mean"] < 0.1
    assert said["error_m"]["batch"]["mean"] < 0.06
    assert said["alignment"]["std"]["yaw_deg"] < 4.0
    assert abs(said["gyro_bias_rad_s"][2] - 0.07) < 0.005
    assert np.diff(t).max() < 0.1001


@pytest.mark.parametrize("layers", ["1", "2"])
def test_an_antenna_whose_place_and_delay_are_not_given_is_found(layers: str) -> None:
    said, _ = located("open", layers)
    assert np.abs(np.array(said["lever_arm_m"]) - LEVER).max() < 0.3  # 3 sigma of so short a flight
    assert abs(said["time_offset_s"] + LATE) < 0.025
    assert said["error_m"]["online"]["mean"] < 0.2
    assert said["error_m"]["batch"]["mean"] < 0.15


@pytest.mark.parametrize("layers", ["1", "2"])
def test_speed_and_course_without_a_climb_are_enough(layers: str) -> None:
    said, _ = located("level", layers)
    assert said["error_m"]["online"]["mean"] < 0.12
    assert said["layers"] == int(layers)
