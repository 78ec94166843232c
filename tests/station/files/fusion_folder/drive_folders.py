"""A simulated drive as a fusion folder with a wheel."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from station.files.fusion_folder import write_tum
from station.files.fusion_folder.fusion_tables import write_wheel
from tests.procedures.fusion.drives import AXLE, GRAVITY, LATITUDE, WHEEL_STD, Drive


def write_drive(folder: Path, drive: Drive, seed: int = 1, wheel: bool = True) -> Path:
    """Write IMU, fixes, truth and, unless it is left out, the wheel of a drive."""
    folder.mkdir(parents=True, exist_ok=True)
    rng, noise = np.random.default_rng(seed), drive.noise
    imu, fixes = drive.imu(rng), drive.fixes(rng)
    _write(
        folder / "imu.csv", "t_s,wx_rad_s,wy_rad_s,wz_rad_s,fx_m_s2,fy_m_s2,fz_m_s2", imu.t, imu.omega_b, imu.f_b
    )
    _write(folder / "gnss.csv", "t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s", fixes.t, fixes.p_n, fixes.v_n)
    write_tum(folder / "truth.tum", drive.truth())
    lines = [
        'format = "fusion/1"',
        "[site]",
        f"latitude_deg = {np.degrees(LATITUDE):.6f}",
        f"gravity_m_s2 = {GRAVITY}",
        "[imu]",
        'file = "imu.csv"',
        f"gyro_noise_rad_s_rthz = {noise.gyro}",
        f"gyro_walk_rad_s2_rthz = {noise.gyro_walk}",
        f"accel_noise_m_s2_rthz = {noise.accel}",
        f"accel_walk_m_s3_rthz = {noise.accel_walk}",
        f"gyro_bias_std_rad_s = {noise.gyro_bias}",
        f"accel_bias_std_m_s2 = {noise.accel_bias}",
        "[gnss]",
        'file = "gnss.csv"',
        f"position_std_m = {fixes.position_std[0]}",
        f"velocity_std_m_s = {fixes.velocity_std[0]}",
        "lever_arm_m = [0.0, 0.0, 0.0]",
        "[truth]",
        'file = "truth.tum"',
    ]
    if wheel:
        write_wheel(folder / "wheel.csv", drive.wheel(rng))
        lines += [
            "[wheel]",
            'file = "wheel.csv"',
            f"wheel_std_m_s = {WHEEL_STD}",
            f"lever_arm_m = {AXLE.tolist()}",
        ]
    (folder / "fusion.toml").write_text("\n".join(lines) + "\n")
    return folder


def _write(path: Path, header: str, *columns: np.ndarray) -> None:
    rows = np.column_stack(columns).tolist()
    path.write_text(header + "\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows))


TOML = """format = "fusion/1"
[site]
latitude_deg = 47.4
gravity_m_s2 = 9.8066
[imu]
file = "imu.csv"
gyro_noise_rad_s_rthz = 3.4e-4
gyro_walk_rad_s2_rthz = 4e-5
accel_noise_m_s2_rthz = 8e-3
accel_walk_m_s3_rthz = 3e-3
[gnss]
file = "gnss.csv"
position_std_m = 0.2
velocity_std_m_s = 0.05
lever_arm_m = [0.0, 0.0, 0.0]
[odometry]
file = "odometry.tum"
[truth]
file = "truth.tum"
"""


def write_folder(folder: Path, seconds: float = 20.0, seed: int = 1) -> Path:
    """Write a folder of every kind of file; the odometry is the truth turned by 1 rad about the vertical."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    t = np.arange(0, seconds, 0.1)
    p = np.stack([5 * np.sin(0.4 * t), 3 * np.sin(0.8 * t), 0.2 * t], axis=1)
    v = np.gradient(p, t, axis=0)
    turn = Rotation.from_rotvec(np.outer(np.arctan2(v[:, 1], v[:, 0]), [0, 0, 1]))
    (folder / "fusion.toml").write_text(TOML)
    write_rows(folder / "truth.tum", " ", np.c_[t, p, turn.as_quat()])
    odometry = Rotation.from_rotvec([0, 0, 1.0])
    write_rows(folder / "odometry.tum", " ", np.c_[t, odometry.apply(p), (odometry * turn).as_quat()])
    noisy = np.c_[t, p + rng.normal(0, 0.2, p.shape), v + rng.normal(0, 0.05, v.shape)]
    write_rows(folder / "gnss.csv", ",", noisy, "t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,vu_m_s")
    still = np.tile([0.0, 0.0, 0.1, 0.0, 0.0, 9.8066], (len(t), 1))
    write_rows(folder / "imu.csv", ",", np.c_[t, still], "t_s,wx_rad_s,wy_rad_s,wz_rad_s,fx_m_s2,fy_m_s2,fz_m_s2")
    return folder


def write_rows(path: Path, comma: str, rows: np.ndarray, header: str = "") -> None:
    """Write numbers with nine digits, a header line first where there is one."""
    text = header + "\n" if header else ""
    path.write_text(text + "".join(comma.join(f"{v:.9f}" for v in row) + "\n" for row in rows))
