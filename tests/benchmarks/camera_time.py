"""Print how well a camera's time offset is found: `python -m tests.benchmarks.camera_time DATA --seeds 10`.

DATA holds fusion/1 folders with real IMU and truth. For every seed a simulated camera flies along the truth as in
`tests.benchmarks.locate_vision`, its stamps off by up to 0.15 s, and the offset is sought in every stretch of the
recording. The truth's own stamps wander against its IMU, on V203 by 9 ms in a minute and a half; what they are off
over a stretch is fitted to the truth's attitudes, without a camera, and taken off: the camera has the truth's
clock.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import process_time

import numpy as np
from scipy.spatial.transform import Rotation, RotationSpline

from procedures.arrays import FloatArray
from procedures.frames import rotation_vector
from procedures.fusion.alignment.alignment_attempts import between
from procedures.fusion.fusion_records import ImuSeries, Trajectory
from procedures.fusion.imu.gyro_rotations import GyroRotations
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.visual_alignment.camera_time import CameraTimeOffset, camera_offset
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.camera_source import by_vision
from tests.benchmarks.locate import HEADS as LOCATED
from tests.benchmarks.locate import INERTIAL, main, row, said
from tests.benchmarks.locate_vision import CAMERA, seen
from tests.drivers.simulated.camera_tracks import View, simulate_tracks
from tests.procedures.fusion.visual_alignment.test_camera_time import along, humming
from tests.procedures.fusion.visual_alignment.test_camera_time import seen as planted

VIEW = View()
SPAN = 15.0  # s of a stretch
LARGEST = 0.15  # s
SILENT = (5.0, 0.01)  # sigmas and s beyond which an error is a silent failure
HEADS = "error [ms], its sigma [ms], error over sigma, t_cpu [s]"
TURN = 0.3  # s, over which the truth's turns are compared
AGREED = 4e-3  # rad: a truth jitters


@dataclass(frozen=True)
class Case:
    """How the camera and what is told of it are: ``camera`` is told, ``bias`` [rad/s] is added to each gyro."""

    view: View = VIEW
    camera: PinholeCamera = CAMERA
    bias: float = 0.0
    span: float = SPAN


@cache
def log_of(data: Path, name: str) -> FusionLog:
    """Return a folder, read once."""
    return read_fusion(data / name)


def stretches(data: Path, case: Case, seeds: int) -> Iterator[tuple[ImuSeries, FeatureTracks, float]]:
    """Yield IMU and tracks of each stretch, and the offset that is to be found."""
    for name in INERTIAL:
        log = log_of(data, name)
        assert log.imu is not None and log.truth is not None  # noqa: PT018
        ends = np.arange(case.span + 1, log.truth.t[-1] - 1, case.span)
        own = [own_offset(between(log.imu, end - case.span, end), log.truth) for end in ends]
        for seed in range(seeds):
            offset = float(np.random.default_rng(seed).uniform(-LARGEST, LARGEST))
            tracks = simulate_tracks(log.truth, CAMERA, case.view, seed).shifted(-offset)
            for end, more in zip(ends, own, strict=True):
                imu = between(log.imu, end - case.span, end)
                rows = (tracks.t >= end - case.span) & (tracks.t <= end)
                part = FeatureTracks(tracks.t[rows], tracks.feature[rows], tracks.uv[rows])
                yield replace(imu, omega_b=imu.omega_b + case.bias), part, offset + more


def own_offset(imu: ImuSeries, truth: Trajectory) -> float:
    """Return what is to be added to the truth's stamps [s], fitted to its attitudes with the gyro's bias."""
    t = np.arange(imu.t[0] + 0.1, imu.t[-1] - TURN - 0.1, 0.1)
    C = [RotationSpline(truth.t, Rotation.from_quat(truth.q))(at).as_matrix() for at in (t, t + TURN)]
    seen_turns, x = np.swapaxes(C[1], 1, 2) @ C[0], np.zeros(4)
    for _ in range(8):
        gyro = GyroRotations(imu, x[1:])
        R, by_bias = gyro.turned(t + x[0], t + TURN + x[0])
        by_time = (R @ gyro.rate(t + x[0])[:, :, None])[:, :, 0] - gyro.rate(t + TURN + x[0])
        off = rotation_vector(seen_turns @ np.swapaxes(R, 1, 2))
        weight = 1 / (1 + np.sum(off**2, axis=1) / AGREED**2)[:, None]
        J = np.concatenate((by_time[:, :, None], by_bias), axis=2)
        Jw = (J * weight[:, :, None]).reshape(-1, 4)
        x = x + np.linalg.solve(Jw.T @ J.reshape(-1, 4), Jw.T @ off.ravel())
    return float(x[0])


def judged(name: str, data: Path, case: Case, seeds: int) -> None:
    """Print errors, sigmas, refusals and silent failures of a case."""
    rows, whys = list[list[float]](), Counter[str]()
    for imu, tracks, offset in stretches(data, case, seeds):
        begun = process_time()
        found = camera_offset(imu, tracks, case.camera)
        took = process_time() - begun
        if isinstance(found, CameraTimeOffset):
            error = abs(found.offset - offset)
            rows.append([1e3 * error, 1e3 * found.std, error / found.std, took])
        else:
            whys[found.why.split("(")[0].rstrip(" 0123456789.:,")[:40]] += 1
    silent = sum(each[2] > SILENT[0] and each[0] > 1e3 * SILENT[1] for each in rows)
    if rows:
        said(f"camera time, {name}", rows, HEADS)
        ratio = np.sqrt(np.mean(np.array(rows)[:, 2] ** 2))
        print(f"  rms of error over sigma {ratio:.2f}", flush=True)
    print(
        f"  {name}: {len(rows)} found, {whys.total()} refused {dict(whys)}, silent failures {silent}", flush=True
    )


def flights(data: Path, seeds: int) -> None:
    """Four flights, stretches of 15 s."""
    judged("15 s of flight", data, Case(), seeds)


def shorter(data: Path, seeds: int) -> None:
    """Shorter and longer stretches."""
    for span in (5.0, 10.0, 30.0):
        judged(f"{span:g} s of flight", data, Case(span=span), seeds)


def wrong(data: Path, seeds: int) -> None:
    """What is told wrong, or seen badly."""
    for axis, name in enumerate("xyz"):
        turn = Rotation.from_rotvec(np.radians(1.0) * np.eye(3)[axis]).as_matrix()
        judged(f"camera told 1 deg wrong about {name}", data, Case(camera=turned(turn)), seeds)
    judged("gyro biases of 0.1 rad/s", data, Case(bias=0.1), seeds)
    judged("10 % outliers", data, Case(view=View(outliers=0.1)), seeds)
    judged("30 features", data, Case(view=View(features=30)), seeds)
    judged("depths of 10 to 50 m", data, Case(view=View(depths=(10.0, 50.0))), seeds)
    judged("5 frames a second", data, Case(view=View(rate=5.0)), seeds)
    for axis, name in enumerate("xyz"):
        turn = Rotation.from_rotvec(np.pi / 2 * np.eye(3)[axis]).as_matrix()
        judged(f"camera told 90 deg wrong about {name}", data, Case(camera=turned(turn)), min(seeds, 2))


def turned(turn: FloatArray) -> PinholeCamera:
    """Return the camera told as if it were turned."""
    return replace(CAMERA, C_bc=CAMERA.C_bc @ turn)


def untold(_: Path, seeds: int) -> None:
    """Motions that do not tell: all are to be refused."""
    motions = {
        "rest": along(0.0, 0.0), "straight on": along(0.0, 1.5), "steady turn": along(0.5, 1.5),
        "the same every 0.2 s": humming,
    }  # fmt: skip
    for name, motion in motions.items():
        for view in (View(), View(depths=(10.0, 50.0))):
            found = [camera_offset(*planted(motion, seed, view=view), CAMERA) for seed in range(seeds)]
            accepted = sum(isinstance(each, CameraTimeOffset) for each in found)
            print(f"{name}, depths {view.depths} m: {accepted} of {seeds} accepted", flush=True)


def left(data: Path, seeds: int) -> None:
    """What an offset left in does to the location, and what it is when it is estimated."""
    for name in ("v203_inertial", "mh03_inertial", "v201_inertial"):
        for late in (0.0, 0.005, 0.02, 0.05):
            told = {"time_offset_s": 0.0}
            said(f"{name}, {late * 1e3:g} ms left in", list(_located(data, name, seeds, late, told)), LOCATED)
        for late in (0.0, 0.005, 0.02):
            said(f"{name}, {late * 1e3:g} ms untold", list(_located(data, name, seeds, late, {})), LOCATED)
        told = {"time_offset_std_s": 0.1}
        said(f"{name}, 80 ms estimated", list(_located(data, name, seeds, 0.08, told)), LOCATED)


def _located(data: Path, name: str, seeds: int, late: float, told: dict[str, float]) -> Iterator[list[float]]:
    for seed in range(seeds):
        log = seen(data, name, seed)
        assert log.tracks is not None and log.camera is not None  # noqa: PT018
        described = read_fusion(data / "v102_tracks").table.tracks
        assert described is not None
        table = log.table.model_copy(update={"tracks": described.model_copy(update=told)})
        late_log = replace(log, tracks=log.tracks.shifted(late), table=table)
        located = by_vision(late_log)
        if located.begun_at is None:
            print(f"  {name}, seed {seed}, {late} s: never, {located.why_not}", flush=True)
        else:
            yield row(late_log, located)


PARTS: dict[str, Callable[[Path, int], None]] = {
    "flights": flights, "shorter": shorter, "wrong": wrong, "untold": untold, "left": left,
}  # fmt: skip

if __name__ == "__main__":
    main(PARTS, __doc__)
