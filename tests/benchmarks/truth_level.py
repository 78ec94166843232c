"""How far the attitudes of a recording's truth are off.

No estimator has a part in it. Over each second of a recording, with the truth's attitudes and velocities,

    v_k+1 - v_k = F + yaw z x F - C b + g T,    F = int C_nb f dt,  C = int C_nb dt

is linear in the accelerometer's bias b (constant in the IMU), in gravity g (constant in the truth's frame) and in
a heading that the truth's attitudes lack. What of g is horizontal is the frame's tilt; a vertical bias of an IMU
that stays upright is not told from g, nor needs it be.
"""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries, Trajectory

SECOND = 1.0
EDGE = 1.0  # s at either end, where a spline's velocity is poor


def off(imu: ImuSeries, truth: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return the tilt of the truth's frame about East and North, the heading it lacks, and 1 sigma, (3,) [rad]."""
    inside = (imu.t > truth.t[0] + EDGE) & (imu.t < truth.t[-1] - EDGE)
    t = imu.t[inside]
    C = Slerp(truth.t, Rotation.from_quat(truth.q))(t).as_matrix()
    force = cumulative_trapezoid(np.einsum("nij,nj->ni", C, imu.f_b[inside]), t, axis=0, initial=0.0)
    turned = cumulative_trapezoid(C, t, axis=0, initial=0.0)
    k = np.searchsorted(t, np.arange(t[0], t[-1], SECOND))
    elapsed = np.diff(t[k])[:, None, None]
    F = np.diff(force[k], axis=0)
    across = np.stack((F[:, 1], -F[:, 0], np.zeros(len(F))), axis=1)[:, :, None]
    A = np.concatenate((np.diff(turned[k], axis=0), -np.eye(3) * elapsed, across), axis=2).reshape(-1, 7)
    y = (F - np.diff(CubicSpline(truth.t, truth.p)(t[k], 1), axis=0)).ravel()
    found = np.linalg.lstsq(A, y, rcond=None)[0]
    covariance = np.linalg.inv(A.T @ A) * np.var(y - A @ found)
    down, std = found[3:6], np.sqrt(np.diag(covariance))[3:]
    g = np.linalg.norm(down)
    return np.array([down[1] / g, -down[0] / g, found[6]]), np.array([std[1] / g, std[0] / g, std[3]])


def righted(imu: ImuSeries, truth: Trajectory) -> Trajectory:
    """Return the truth with its attitudes put right; its heading only where that is off by 3 sigma."""
    about, std = off(imu, truth)
    heading = about[2] if abs(about[2]) > 3 * std[2] else 0.0
    turn = Rotation.from_rotvec([-about[0], -about[1], heading])
    return Trajectory(truth.t, truth.p, (turn * Rotation.from_quat(truth.q)).as_quat())
