"""Print how far each truth's frame is from level: `python -m tests.benchmarks.truth_level DATA`.

No estimator has a part in it. Over each second of a recording, with the truth's attitudes and velocities,

    v_k+1 - v_k = int C_nb f dt - C b + g T,    C = int C_nb dt

is linear in the accelerometer's bias b (constant in the IMU) and in gravity g (constant in the truth's frame).
What of g is horizontal is the frame's tilt; a vertical bias of an IMU that stays upright is not told from g, nor
needs it be.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import FloatArray
from procedures.frames import rotation
from procedures.fusion.records import ImuSeries, Trajectory
from station.fusion_folder import read_fusion

SECOND = 1.0
EDGE = 1.0  # s at either end, where a spline's velocity is poor


def tilt(imu: ImuSeries, truth: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return the tilt of the truth's frame about its East and North, and its 1 sigma, each (2,) [rad]."""
    inside = (imu.t > truth.t[0] + EDGE) & (imu.t < truth.t[-1] - EDGE)
    t = imu.t[inside]
    C = Slerp(truth.t, Rotation.from_quat(truth.q))(t).as_matrix()
    force = cumulative_trapezoid(np.einsum("nij,nj->ni", C, imu.f_b[inside]), t, axis=0, initial=0.0)
    turned = cumulative_trapezoid(C, t, axis=0, initial=0.0)
    k = np.searchsorted(t, np.arange(t[0], t[-1], SECOND))
    elapsed = np.diff(t[k])[:, None, None]
    A = np.concatenate((np.diff(turned[k], axis=0), -np.eye(3) * elapsed), axis=2).reshape(-1, 6)
    y = (np.diff(force[k], axis=0) - np.diff(CubicSpline(truth.t, truth.p)(t[k], 1), axis=0)).ravel()
    found = np.linalg.lstsq(A, y, rcond=None)[0]
    covariance = np.linalg.inv(A.T @ A) * np.var(y - A @ found)
    down, std = found[3:], np.sqrt(np.diag(covariance))[3:]
    g = np.linalg.norm(down)
    return np.array([down[1], -down[0]]) / g, std[[1, 0]] / g


def levelling(imu: ImuSeries, truth: Trajectory) -> FloatArray:
    """Return the rotation (3, 3) from the truth's frame to the level one of the same heading."""
    about = tilt(imu, truth)[0]
    turn: FloatArray = rotation(np.array([-about[0], -about[1], 0.0]))
    return turn


if __name__ == "__main__":
    for folder in sorted(Path(sys.argv[1]).iterdir()):
        if folder.is_dir() and (log := read_fusion(folder)).imu is not None and log.truth is not None:
            about, std = np.degrees(tilt(log.imu, log.truth))
            print(f"{folder.name:<16}tilt about East, North {about.round(3)} deg, 1 sigma {max(std):.3f}")
