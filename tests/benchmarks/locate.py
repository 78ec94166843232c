"""What locating reaches on real recordings of IMU and camera odometry, with GNSS drawn from their truth.

GNSS is drawn anew for every seed: white, 0.2 m per axis and 0.05 m/s at 20 Hz, as Han 2022 has it. Errors are
position errors of the IMU without any alignment, over the poses later than `WARM_UP`.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import interpolated
from procedures.fusion.fusion_records import GnssFixes, Trajectory
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.imu_source import by_imu
from station.locate.locate_folder import by_odometry, position_errors
from station.locate.outer_layer import Located
from tests.benchmarks.truth_level import righted
from tests.paths import DATA
from tests.proof.evidence import Figure

WARM_UP = 15.0  # s
ODOMETRY = ("mh01_odometry", "mh03_inertial", "v201_inertial", "v203_inertial")
INERTIAL = ("mh03_inertial", "v102_tracks", "v201_inertial", "v203_inertial")
OUTAGE = (50.0, 70.0)  # s, of v201_outage
SILENT = (50.0, 60.0)  # s, of a recording of IMU


def drawn(
    log: FusionLog, seed: int, outliers: float = 0.0, gap: tuple[float, float] | None = None, spacing: float = 0.05
) -> FusionLog:
    """Return a folder with GNSS drawn anew from its truth, a fix every ``spacing`` [s] but for a ``gap``."""
    assert log.truth is not None
    rng, path = np.random.default_rng(seed), CubicSpline(log.truth.t, log.truth.p)
    t = np.arange(0.2, log.truth.t[-1], spacing)
    if gap is not None:
        t = t[(t < gap[0]) | (t > gap[1])]
    p = path(t) + rng.normal(0, 0.2, (len(t), 3))
    v = path(t, 1) + rng.normal(0, 0.05, (len(t), 3))
    away = rng.normal(size=p.shape)
    p += 5.0 * away / np.linalg.norm(away, axis=1)[:, None] * (rng.random(len(t)) < outliers)[:, None]
    n = len(t)
    return replace(log, fixes=GnssFixes(t, p, v, np.full(n, np.nan), np.full(n, 0.2), np.full(n, 0.05)))


def attitude_errors(trajectory: Trajectory, truth: Trajectory) -> tuple[float, float]:
    """Return tilt and yaw error [deg rms] after the warm-up."""
    k = (trajectory.t > WARM_UP) & (trajectory.t < truth.t[-1])
    true = Slerp(truth.t, Rotation.from_quat(truth.q))(trajectory.t[k])
    E = (Rotation.from_quat(trajectory.q[k]) * true.inv()).as_matrix()
    tilt, yaw = np.arccos(np.clip(E[:, 2, 2], -1, 1)), np.arctan2(E[:, 1, 0], E[:, 0, 0])
    return float(np.degrees(np.sqrt(np.mean(tilt**2)))), float(np.degrees(np.sqrt(np.mean(yaw**2))))


def consistency(located: Located, truth: Trajectory) -> tuple[float, float]:
    """Return the normalised errors squared of online position and yaw, per axis, over their own covariance: 1."""
    k = (located.online.t > WARM_UP) & (located.online.t < truth.t[-1])
    assert located.covariance is not None
    t, P = located.online.t[k], located.covariance[k]
    e = located.online.p[k] - interpolated(t, truth.t, truth.p)
    E = (
        Rotation.from_quat(located.online.q[k]) * Slerp(truth.t, Rotation.from_quat(truth.q))(t).inv()
    ).as_matrix()
    position = np.einsum("ni,ni->n", e, np.linalg.solve(P[:, :3, :3], e[..., None])[..., 0]) / 3
    return float(position.mean()), float(np.mean(np.arctan2(E[:, 1, 0], E[:, 0, 0]) ** 2 / P[:, 3, 3]))


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
        for title, unit, value in zip(TITLES, UNITS, np.mean(rows, axis=0), strict=True):
            result[f"{what}: {title}"] = Figure(float(value), unit)
    return result


TITLES = ("position online, mean", "worst, mean over runs", "position smoothed, mean", "tilt", "yaw",
          "normalised error squared of position (1 expected)", "the same of yaw")  # fmt: skip
UNITS = ("m", "m", "m", "deg rms", "deg rms", "", "")


def row(log: FusionLog, located: Located) -> list[float]:
    """Return the numbers of `TITLES` of one run; attitudes against the truth put level."""
    assert log.truth is not None
    online, smoothed = (position_errors(part, log.truth, WARM_UP) for part in (located.online, located.smoothed))
    assert online is not None
    assert smoothed is not None
    right = log.truth if log.imu is None else righted(log.imu, log.truth)
    attitude = attitude_errors(located.online, right)
    return [online.mean, online.worst, smoothed.mean, *attitude, *consistency(located, right)]
