"""Print what a camera brings: `python -m tests.benchmarks.locate_vision DATA [PART ...] --seeds 10`.

DATA holds fusion/1 folders with real IMU and truth. For every seed GNSS is drawn anew from the truth as in
`tests.benchmarks.locate`, and a simulated camera (`tests.drivers.simulated.camera_tracks`: 10 Hz, 120 features at
2 to 8 m, 1 px, 2 % of the points displaced, intrinsics and place on the IMU of EuRoC's left camera) flies along
it. Errors are without any alignment, over the poses later than the warm-up; median and worst over the seeds.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from procedures.arrays import FloatArray
from procedures.earth.gravity_and_rate import earth_rate_n
from procedures.fusion.alignment.alignment_result import Waiting
from procedures.fusion.imu.gnss_velocity import LeverArm
from procedures.fusion.inner.inertial_terms import Site
from procedures.fusion.inner.visual_inertial_window import VisionSettings, VisualInertialWindow
from procedures.fusion.vision.feature_tracks import PinholeCamera
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner
from procedures.fusion.visual_alignment.visual_start import VisualStart
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.camera_source import by_vision
from tests.benchmarks.locate import HEADS, INERTIAL, OUTAGE, drawn, main, row, said
from tests.drivers.simulated.camera_tracks import View, simulate_tracks

WRONG = 15.0  # deg of yaw beyond which an accepted alignment is a silent failure
EVERY = 3.0  # s between the starts that are tried
C_BC = [[0.0148655429818, -0.999880929698, 0.00414029679422], [0.999557249008, 0.0149672133247, 0.025715529948]]
C_BC += [[-0.0257744366974, 0.00375618835797, 0.999660727178]]
T_BC = [-0.0216401454975, -0.064676986768, 0.00981073058949]
CAMERA = PinholeCamera(458.654, 457.296, 367.215, 248.375, 1.0, np.array(C_BC), np.array(T_BC))


def seen(data: Path, name: str, seed: int, gap: tuple[float, float] | None = None) -> FusionLog:
    """Return a folder with GNSS and tracks drawn anew."""
    log = drawn(read_fusion(data / name), seed, gap=gap)
    assert log.truth is not None
    return replace(log, tracks=simulate_tracks(log.truth, CAMERA, View(), seed), camera=CAMERA)


def sequences(data: Path, seeds: int) -> None:
    """Figure 3: tracks, real IMU and GNSS velocity in the window, the outer graph on it."""
    means = []
    for name in INERTIAL:
        rows = [row(log := seen(data, name, seed), by_vision(log)) for seed in range(seeds)]
        means.append(said(f"camera {name}", rows, HEADS))
    print(f"camera, mean of sequences: {', '.join(f'{m:.4f}' for m in np.mean(means, axis=0))}", flush=True)


def outage(data: Path, seeds: int) -> None:
    """Figure 3: 20 s without GNSS."""
    rows = [row(log := seen(data, "v201_outage", seed, OUTAGE), by_vision(log)) for seed in range(seeds)]
    said("camera, 20 s outage v201", rows, HEADS)


def starting(data: Path, seeds: int) -> None:
    """Han's table I: scale at initialisation before and after the joint refinement, from starts all along."""
    for name in INERTIAL:
        rows, whys = list[list[float]](), Counter[str]()
        for seed in range(seeds):
            log = seen(data, name, seed)
            for found, cost in _starts(log):
                if isinstance(found, Waiting):
                    whys[found.why.split(":")[0].rstrip(" 0123456789.%")[-40:]] += 1
                else:
                    rows.append([*_start_errors(log, found), cost])
        print(f"{name}: {len(rows)} starts, {whys.total()} refused {dict(whys)}")
        said(
            f"start {name}",
            rows,
            "scale before, after, its sigma [%], tilt, yaw, its sigma [deg], t [s], t_cpu [s]",
        )
        print(f"silent failures {sum(each[4] > WRONG for each in rows)}", flush=True)


def _settings(log: FusionLog) -> VisionSettings:
    assert log.noise is not None
    return VisionSettings(Site(log.gravity, earth_rate_n(log.latitude), log.noise), CAMERA, LeverArm(np.zeros(3)))


def _starts(log: FusionLog) -> Iterator[tuple[VisualStart | Waiting, float]]:
    assert log.noise is not None and log.imu is not None  # noqa: PT018
    assert log.tracks is not None and log.truth is not None  # noqa: PT018
    aligner = VisualAligner(_settings(log))
    for now in np.arange(EVERY, log.truth.t[-1] - 1, EVERY):
        begun = process_time()
        found = aligner.align(log.imu, log.tracks, log.fixes, float(now))
        yield found, process_time() - begun


def _start_errors(log: FusionLog, found: VisualStart) -> list[float]:
    assert log.truth is not None
    true = CubicSpline(log.truth.t, log.truth.p)(found.t)
    at = Slerp(log.truth.t, Rotation.from_quat(log.truth.q))(found.aligned.t).as_matrix()
    E = found.aligned.C_now @ at.T
    tilt, yaw = np.degrees([np.arccos(np.clip(E[2, 2], -1, 1)), abs(np.arctan2(E[1, 0], E[0, 0]))])
    scales = [100 * abs(_scale(way, true) - 1) for way in (found.rough, found.refined)]
    std = [100 * found.scale_std, float(tilt), float(yaw), float(np.degrees(found.aligned.yaw_std))]
    return [*scales, *std, float(found.t[-1] - found.t[0])]


def _scale(way: FloatArray, true: FloatArray) -> float:
    """Return how much longer a way is than the true one, the two turned onto each other (Umeyama)."""
    a, b = way - way.mean(axis=0), true - true.mean(axis=0)
    U, S, Vt = np.linalg.svd(b.T @ a)
    return float((S * [1, 1, np.linalg.det(U @ Vt)]).sum() / np.sum(b**2))


def times(data: Path, _: int) -> None:
    """Figure 7: processor time of a window of ten keyframes."""
    log = seen(data, "v201_inertial", 0)
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    found = next(each for each, _ in _starts(log) if isinstance(each, VisualStart))
    window = VisualInertialWindow(_settings(log), log.imu, log.tracks, log.fixes, found.aligned)
    took, begun = list[float](), process_time()
    for _pose in window.poses():
        took.append(process_time() - begun)
        begun = process_time()
    took_ms = np.array(took[20:]) * 1e3
    print(
        f"a window of {window.settings.frames} keyframes: {took_ms.mean():.1f} ms mean, {took_ms.max():.0f} worst"
    )


PARTS = {"times": times, "outage": outage, "sequences": sequences, "starting": starting}

if __name__ == "__main__":
    main(PARTS, __doc__)
