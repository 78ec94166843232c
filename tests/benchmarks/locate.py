"""What locating reaches on real recordings of IMU and camera odometry, with GNSS drawn from their truth.

GNSS is drawn again for every seed: white, 0.2 m per axis and 0.05 m/s at 20 Hz, as Han 2022 has it. Errors are
position errors of the IMU without any alignment, over the poses later than `WARM_UP`.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import FloatArray, interpolated
from procedures.fusion.fusion_records import GnssFixes, ImuSeries, Trajectory
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.imu_source import by_imu
from station.locate.locate_folder import by_odometry, position_errors
from station.locate.outer_layer import Located
from tests.paths import DATA
from tests.proof.evidence import Figure

WARM_UP = 15.0  # s
ODOMETRY = ("mh01_odometry", "mh03_inertial", "v201_inertial", "v203_inertial")
INERTIAL = ("mh03_inertial", "v102_tracks", "v201_inertial", "v203_inertial")
OUTAGE = (50.0, 70.0)  # s, of v201_outage
SILENT = (50.0, 60.0)  # s, of a recording of IMU
SECOND, EDGE = 1.0, 1.0  # s, each of a recording; at either end of a truth, where a spline's velocity is poor


def drawn(
    log: FusionLog, seed: int, outliers: float = 0.0, gap: tuple[float, float] = (np.inf, np.inf)
) -> FusionLog:
    """Return a folder with GNSS drawn again from its truth, but for a ``gap`` [s]."""
    rng, path = np.random.default_rng(seed), CubicSpline(log.truth.t, log.truth.p)
    t = np.arange(0.2, log.truth.t[-1], 0.05)
    t = t[(t < gap[0]) | (t > gap[1])]
    p = path(t) + rng.normal(0, 0.2, (len(t), 3))
    v = path(t, 1) + rng.normal(0, 0.05, (len(t), 3))
    away = rng.normal(size=p.shape)
    p += 5.0 * away / np.linalg.norm(away, axis=1)[:, None] * (rng.random(len(t)) < outliers)[:, None]
    n = len(t)
    return replace(log, fixes=GnssFixes(t, p, v, np.full(n, np.nan), np.full(n, 0.2), np.full(n, 0.05)))


def errors(located: Located, truth: Trajectory) -> list[float]:
    """Return tilt and yaw error online [deg rms], and position and yaw errors squared over their covariance: 1."""
    k = (located.online.t > WARM_UP) & (located.online.t < truth.t[-1])
    t, P = located.online.t[k], located.covariance[k]
    true = Slerp(truth.t, Rotation.from_quat(truth.q))(t)
    E = (Rotation.from_quat(located.online.q[k]) * true.inv()).as_matrix()
    tilt, yaw = np.arccos(np.clip(E[:, 2, 2], -1, 1)), np.arctan2(E[:, 1, 0], E[:, 0, 0])
    e = located.online.p[k] - interpolated(t, truth.t, truth.p)
    position = np.einsum("ni,ni->n", e, np.linalg.solve(P[:, :3, :3], e[..., None])[..., 0]) / 3
    rms = [float(np.degrees(np.sqrt(np.mean(angle**2)))) for angle in (tilt, yaw)]
    return [*rms, float(position.mean()), float(np.mean(yaw**2 / P[:, 3, 3]))]


def off(imu: ImuSeries, truth: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return the tilt of the truth's frame about East and North, the heading it lacks, and 1 sigma, (3,) [rad].

    No estimator has a part in it. Over each second, with the truth's attitudes and velocities,

        v_k+1 - v_k = F + yaw z x F - C b + g T,    F = int C_nb f dt,  C = int C_nb dt

    is linear in the accelerometer's bias b (constant in the IMU), in gravity g (constant in the truth's frame) and
    in a heading that the truth's attitudes lack. What of g is horizontal is the frame's tilt; a vertical bias of
    an IMU that stays upright is not told from g, nor needs it be.
    """
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


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return errors over the recordings and ``size`` draws of GNSS each."""
    runs: dict[str, tuple[tuple[str, ...], Callable[[FusionLog], Located], float]] = {
        "odometry": (ODOMETRY, by_odometry, 0.0),
        "odometry, 10 % of the fixes off by 5 m": (ODOMETRY, by_odometry, 0.1),
        "IMU": (INERTIAL, lambda log: by_imu(log, 2), 0.0),
    }
    result = dict[str, Figure]()
    for what, (names, run, outliers) in runs.items():
        rows = list[list[float]]()
        for name in names:
            log = read_fusion(DATA / "fusion" / name)
            rows += [row(one := drawn(log, seed + i, outliers), run(one)) for i in range(size)]
        for (title, unit), value in zip(TITLES.items(), np.mean(rows, axis=0), strict=True):
            result[f"{what}: {title}"] = Figure(float(value), unit)
    return result


TITLES = {"position online, mean": "m", "worst, mean over runs": "m", "position smoothed, mean": "m",
          "tilt": "deg rms", "yaw": "deg rms", "normalised error squared of position (1 expected)": "",
          "the same of yaw": ""}  # fmt: skip


def row(log: FusionLog, located: Located) -> list[float]:
    """Return the numbers of `TITLES` of one run; attitudes against the truth put level."""
    online, smoothed = (position_errors(part, log.truth, WARM_UP) for part in (located.online, located.smoothed))
    right = log.truth if log.imu is None else righted(log.imu, log.truth)
    return [online.mean, online.worst, smoothed.mean, *errors(located, right)]
