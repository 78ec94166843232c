"""Print what locating reaches: `python -m tests.benchmarks.locate DATA [PART ...] --seeds 10`.

DATA holds fusion/1 folders with truth. GNSS is drawn anew from each truth for every seed: white, 0.2 m per axis
and 0.05 m/s at 20 Hz, as Han 2022 and the folders' SOURCE.txt have it. Errors are position errors of the IMU
without any alignment, over the poses later than `WARM_UP`; of each figure median and worst over the seeds.
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import interpolated
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.frames import rotation, vertical_rotation
from procedures.fusion.alignment.alignment_at_rest import align_at_rest
from procedures.fusion.alignment.alignment_attempts import between, fixes_between
from procedures.fusion.alignment.alignment_in_motion import MovingAligner
from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import GnssFixes, ImuNoise, ImuSeries, Trajectory
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.inertial_window import InertialWindow, WindowSettings
from procedures.units import RAD_S_PER_DEG_H
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.imu_source import by_imu
from station.locate.location_json import position_errors
from station.locate.odometry_source import by_odometry
from station.locate.result import Located
from tests.benchmarks.truth_level import levelling, righted
from tests.procedures.fusion.alignment.printed_alignment import align_as_printed

WARM_UP = 15.0  # s
ODOMETRY = ("mh01_odometry", "mh03_inertial", "v201_inertial", "v203_inertial")
INERTIAL = ("mh03_inertial", "v102_tracks", "v201_inertial", "v203_inertial")
OUTAGE = (50.0, 70.0)  # s, of v201_outage
SILENT = (50.0, 60.0)  # s, of a recording of IMU
SPAN = 10.0  # s behind an alignment
WRONG = 15.0  # deg of yaw beyond which an accepted alignment is a silent failure


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


def said(name: str, rows: Iterable[Iterable[float]], heads: str) -> list[float]:
    """Print median and worst of each column, and return the medians."""
    table = np.array([list(row) for row in rows])
    medians = np.median(table, axis=0)
    cells = (f"{m:.4f} / {w:.4f}" for m, w in zip(medians, table.max(axis=0), strict=True))
    print(f"{name:<40} {heads}: {', '.join(cells)}", flush=True)
    return [float(m) for m in medians]


def row(log: FusionLog, located: Located) -> list[float]:
    """Return online mean and worst, smoothed mean, tilt and yaw of one run, and how honest its covariance is."""
    assert log.truth is not None
    online, smoothed = (position_errors(part, log.truth, WARM_UP) for part in (located.online, located.smoothed))
    assert online is not None
    assert smoothed is not None
    right = log.truth if log.imu is None else righted(log.imu, log.truth)
    attitude = (*attitude_errors(located.online, log.truth), *attitude_errors(located.online, right))
    found = [online.mean, online.worst, smoothed.mean, *attitude, *consistency(located, right)]
    print(f"  {' '.join(f'{value:.4f}' for value in found)}", file=sys.stderr, flush=True)
    return found


HEADS = "online mean, worst, smoothed mean [m], tilt, yaw [deg rms], of the truth put right, NEES of position, yaw"
Run = Callable[[FusionLog], Located]


def sequences(data: Path, names: Iterable[str], seeds: int, run: Run, what: str, outliers: float = 0.0) -> None:
    """Print a run over sequences, and the mean over them."""
    means = []
    for name in names:
        log = read_fusion(data / name)
        rows = [row(one := drawn(log, seed, outliers), run(one)) for seed in range(seeds)]
        means.append(said(f"{what} {name}", rows, HEADS))
    print(f"{what}, mean of sequences: {', '.join(f'{m:.4f}' for m in np.mean(means, axis=0))}", flush=True)


def odometry(data: Path, seeds: int) -> None:
    """Figure 2: the outer layer on recorded odometry, clean and with outliers, and through an outage."""
    sequences(data, ODOMETRY, seeds, by_odometry, "odometry")
    sequences(data, ODOMETRY, seeds, by_odometry, "odometry, 10 % outliers", 0.1)
    log = read_fusion(data / "v201_outage")
    rows = [row(one := drawn(log, seed, gap=OUTAGE), by_odometry(one)) for seed in range(seeds)]
    said("odometry, 20 s outage", rows, HEADS)


def inertial(data: Path, seeds: int) -> None:
    """Figure 1: IMU, velocity and position, one layer and two."""
    for layers in (1, 2):
        sequences(data, INERTIAL, seeds, lambda log, n=layers: by_imu(log, n), f"inertial, layers {layers}")


def sparse(data: Path, seeds: int) -> None:
    """A fix a second, and ten seconds without any: how far the IMU goes astray, and whether its sigma says so."""
    for name in ("mh03_inertial", "v203_inertial"):
        log = read_fusion(data / name)
        for layers in (1, 2):
            rows = [row(one := drawn(log, seed, spacing=1.0), by_imu(one, layers)) for seed in range(seeds)]
            said(f"1 Hz, layers {layers} {name}", rows, HEADS)
    for layers in (1, 2):
        ends = []
        for name, seed in ((name, seed) for seed in range(seeds) for name in ("mh03_inertial", "v203_inertial")):
            one = drawn(read_fusion(data / name), seed, gap=SILENT)
            ends.append(_at_the_end(one, by_imu(one, layers)))
            print(f"  {name} {' '.join(f'{value:.3f}' for value in ends[-1])}", file=sys.stderr, flush=True)
        said(
            f"10 s outage, layers {layers}",
            ends,
            "error at its end, sigma there, at its start [m], (error/sigma)^2 / 3",
        )


def _at_the_end(log: FusionLog, located: Located) -> list[float]:
    """Return error and sigma at the end of the outage, the sigma before it, and what they are to each other."""
    assert log.truth is not None
    assert located.covariance is not None
    last, first = np.searchsorted(located.online.t, (SILENT[1] - 0.05, SILENT[0])) - 1
    at = np.array([np.interp(located.online.t[last], log.truth.t, log.truth.p[:, i]) for i in range(3)])
    e, P = located.online.p[last] - at, located.covariance[:, :3, :3]
    sigma = np.sqrt(np.trace(P[[last, first]], axis1=1, axis2=2))
    return [float(np.linalg.norm(e)), *sigma.tolist(), float(e @ np.linalg.solve(P[last], e) / 3)]


def aligning(data: Path, seeds: int) -> None:
    """Figure 4: alignment in motion from ten seconds without known biases, and eq. 3 as printed beside it.

    Tilt is also told against the truth's own level (`truth_level`): of the V2 recordings it is half a degree off.
    """
    found, printed, tried = list[list[float]](), list[list[float]](), 0
    for name in INERTIAL:
        log = read_fusion(data / name)
        assert log.imu is not None and log.noise is not None and log.truth is not None  # noqa: PT018
        level = levelling(log.imu, log.truth)
        true = Slerp(log.truth.t, Rotation.from_quat(log.truth.q))
        aligner = MovingAligner(log.noise, log.gravity, earth_rate_n(log.latitude), np.zeros(3))
        for imu, seen in _spans(log, seeds):
            at, result = true(seen.t[-1]).as_matrix().T, aligner.align(imu, seen)
            printed.append(_off(align_as_printed(imu, seen, log.gravity, np.zeros(3)) @ at, level))
            tried += 1
            if isinstance(result, AlignmentState):
                found.append([*_off(result.C_now @ at, level), np.degrees(result.yaw_std)])
    said("alignment in motion, 10 s", found, "tilt, tilt against level, yaw, its sigma [deg]")
    said("eq. 3 as printed, 10 s", printed, "tilt, tilt against level, yaw [deg]")
    silent = sum(yaw > WRONG for _, _, yaw, _ in found)
    print(f"accepted {len(found)}, refused {tried - len(found)}, silent failures {silent}", flush=True)


def _spans(log: FusionLog, seeds: int) -> Iterator[tuple[ImuSeries, GnssFixes]]:
    """Yield the IMU and GNSS of every `SPAN` of a recording, for each seed."""
    assert log.imu is not None and log.truth is not None  # noqa: PT018
    for seed in range(seeds):
        fixes = drawn(log, seed).fixes
        for begin in np.arange(log.imu.t[0] + 0.5, log.truth.t[-1] - SPAN - 1, SPAN):
            seen = fixes_between(fixes, begin, begin + SPAN)
            yield between(log.imu, begin - 0.1, begin + SPAN + 0.1), seen


def _off(E: np.ndarray, level: np.ndarray) -> list[float]:
    """Return tilt, tilt against the level frame, and yaw [deg] of an error rotation."""
    tilts = [np.arccos(np.clip(each[2, 2], -1, 1)) for each in (E, E @ level.T)]
    return [float(np.degrees(angle)) for angle in (*tilts, abs(np.arctan2(E[1, 0], E[0, 0])))]


def bench(_: Path, seeds: int) -> None:
    """Figure 6: a FOG on the bench, 0.05 deg/h at 55 deg, ten degrees wrong at first, after 300 s."""
    earth, gravity = earth_rate_n(np.radians(55.0)), 9.815
    noise = ImuNoise(0.003 * np.pi / 180 / 60, 1e-10, 5e-5, 1e-7, 0.05 * RAD_S_PER_DEG_H, 5e-5)
    rows = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        bias, t = rng.normal(size=3) * noise.gyro_bias, np.arange(0.0, 300.0, 0.1)
        C = vertical_rotation(rng.uniform(-3, 3)) @ rotation(rng.normal(size=3) * 0.05)
        white = rng.normal(size=(2, len(t), 3)) * 10**0.5
        imu = ImuSeries(
            t, C.T @ earth + bias + white[0] * noise.gyro, C.T @ [0, 0, gravity] + white[1] * noise.accel
        )
        start = align_at_rest(imu, noise, gravity, earth)
        assert isinstance(start, AlignmentState)
        start = replace(start, C_nb=vertical_rotation(np.radians(10.0)) @ start.C_nb)
        nan = np.full((1, 3), np.nan)
        none = GnssFixes(t[:1], np.zeros((1, 3)), nan, nan[:, 0], np.ones(1), nan[:, 0])
        settings = WindowSettings(Site(gravity, earth, noise), np.zeros(3), still_std=1e-3, spacing=1.0, frames=20)
        window = InertialWindow(settings, imu, none, start)
        *_, last = window.poses()
        E = last.C_ob @ C.T
        yaw, explained = np.arctan2(E[1, 0], E[0, 0]), (C @ bias)[0] / earth[1]
        sigma = np.sqrt(window.covariance_n[3, 3])
        rows.append([abs(np.degrees(yaw - explained)), abs(np.degrees(yaw)), np.degrees(sigma), abs(yaw) / sigma])
    said("FOG bench, 300 s", rows, "yaw less east bias, yaw, sigma [deg], yaw / sigma")


def times(data: Path, _: int) -> None:
    """Figure 7: how long the inner window and the outer graph take."""
    from procedures.fusion.odometry import RecordedOdometry
    from procedures.fusion.outer.pose_graph import PoseGraph

    log = drawn(read_fusion(data / "v201_inertial"), 0)
    located = by_imu(log, 1)
    print(f"inner window, one layer      {np.mean(located.seconds) * 1e3:.2f} ms mean a keyframe, "
          f"{located.seconds.max() * 1e3:.0f} worst")  # fmt: skip
    assert log.odometry is not None
    graph = PoseGraph()
    poses = list(graph.run(RecordedOdometry(log.odometry), log.fixes))
    start = perf_counter()
    graph.polished()
    print(f"outer graph, all {len(poses)} nodes   {(perf_counter() - start) * 1e3:.0f} ms to convergence")


PARTS = {
    "odometry": odometry,
    "inertial": inertial,
    "sparse": sparse,
    "aligning": aligning,
    "bench": bench,
    "times": times,
}


def main(parts: dict[str, Callable[[Path, int], None]], about: str | None) -> None:
    """Run the parts that the command line names, or all."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("data", type=Path)
    parser.add_argument("parts", nargs="*", default=list(parts))
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    for part in given.parts:
        parts[part](given.data, given.seeds)


if __name__ == "__main__":
    main(PARTS, __doc__)
