"""A fusion folder of the KITTI recording that lies inside the gtsam wheel.

469 s of a car in Karlsruhe, IMU at 100 Hz, a GNSS position a second, no GNSS velocity (Geiger, Lenz,
Stiller, Urtasun 2013; CC BY-NC-SA, so that it is read there and not kept here). There is no independent truth: of
the fixes only every tenth is used, and the others are what the trajectory is measured against.
"""

import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.fusion.fusion_records import Trajectory
from station import cli
from station.files.fusion_folder import read_tum
from station.locate.locate_folder import distances
from tests.proof.evidence import Figure, zero

IMU_FILE, GNSS_FILE = "KittiEquivBiasedImu.txt", "KittiGps_converted.txt"
STRAIGHT, MANY = 2e-3, 8  # rad/s or m/s2 of bend, and rows in a line, that no car makes
IMU_HEADER = "t_s,wx_rad_s,wy_rad_s,wz_rad_s,fx_m_s2,fy_m_s2,fz_m_s2"
TOML = """format = "fusion/1"
[site]
latitude_deg = 49.0
height_m = 115.0
[imu]                                  # densities: the recording's own metadata, at 100 Hz
file = "imu.csv"
gyro_noise_rad_s_rthz = 1.75e-4
gyro_walk_rad_s2_rthz = 2.91e-6
accel_noise_m_s2_rthz = 0.01
accel_walk_m_s3_rthz = 1.67e-4
gyro_bias_std_rad_s = 1e-3
accel_bias_std_m_s2 = 0.1
[gnss]
file = "gnss.csv"
position_std_m = 0.07                  # what gtsam's own example gives it
lever_arm_m = [0.0, 0.0, 0.0]
"""


def recording() -> tuple[FloatArray, FloatArray]:
    """Return the IMU (n, 7), as a fusion folder has it, and the fixes (m, 4) within it."""
    wheel = find_spec("gtsam")
    if wheel is None or wheel.origin is None:
        raise FileNotFoundError("the recording lies in the wheel of gtsam: `pip install --no-deps gtsam`")
    data = Path(wheel.origin).parent / "Data"
    rows = np.loadtxt(data / IMU_FILE, skiprows=1)
    rows = rows[1:]  # two seconds are missing behind the first
    fixes = np.loadtxt(data / GNSS_FILE, skiprows=1, delimiter=",")
    zero = rows[0, 0]
    imu = np.c_[rows[:, 0] - zero, rows[:, 5:8], rows[:, 2:5]]
    fixes[:, 0] -= zero
    imu = imu[~_filled(imu)]
    return imu, fixes[(fixes[:, 0] > 0) & (fixes[:, 0] < imu[-1, 0])]


def _filled(imu: FloatArray) -> BoolArray:
    """Say which rows stand on a straight line: samples that were lost, and filled in by who converted them."""
    bent = np.abs(np.diff(imu[:, 1:], 2, axis=0)).max(axis=1)
    line = np.r_[False, bent < STRAIGHT, False].astype(np.int8)
    begin, end = np.flatnonzero(np.diff(line) == 1) + 1, np.flatnonzero(np.diff(line) == -1) + 1
    filled = np.zeros(len(imu), np.bool_)
    for first, last in zip(begin, end, strict=True):
        filled[first:last] = last - first > MANY
    return filled


def write_kitti(folder: Path, every: int, seconds: float = np.inf) -> FloatArray:
    """Write a fusion folder that has every so many of the fixes, and return the others (k, 4)."""
    folder.mkdir(parents=True, exist_ok=True)
    imu, fixes = recording()
    imu, fixes = imu[imu[:, 0] < seconds], fixes[fixes[:, 0] < seconds]
    (folder / "fusion.toml").write_text(TOML)
    np.savetxt(folder / "imu.csv", imu, "%.9f", ",", header=IMU_HEADER, comments="")
    np.savetxt(folder / "gnss.csv", fixes[::every], "%.9f", ",", header="t_s,e_m,n_m,u_m", comments="")
    return fixes[np.arange(len(fixes)) % every > 0] if every > 1 else fixes


def held_out(trajectory: Trajectory, fixes: FloatArray) -> FloatArray:
    """Return the distance [m] of the trajectory from each fix that it spans."""
    at = Trajectory(fixes[:, 0], fixes[:, 1:], np.tile([0.0, 0.0, 0.0, 1.0], (len(fixes), 1)))
    off = distances(at, trajectory)
    return off[np.isfinite(off)]


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Locate the car by every ``size``-th fix; return the distances from those that were held out."""
    result = dict[str, Figure]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        held = write_kitti(folder, size)
        code = cli.run(["locate", name, "--out", str(folder / "t.tum"), "--batch", str(folder / "b.tum")])
        result["exit code"] = zero(code)
        for what, file, limit in (("online", "t.tum", None), ("smoothed", "b.tum", 0.7)):
            off = held_out(read_tum(folder, file, 1), held)
            result[f"{what}: mean distance"] = Figure(off.mean(), "m", at_most=limit)
            result[f"{what}: 95 % of fixes within"] = Figure(float(np.percentile(off, 95)), "m")
            result[f"{what}: fixes held out"] = Figure(len(off))
    return result
