"""The offset of a camera's stamps is found again on planted motions, judged by its own sigma, or refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks
from procedures.fusion.fusion_records import ImuSeries, Trajectory, Waiting
from procedures.fusion.vision.camera_time import CameraTimeOffset, camera_offset
from tests.drivers.simulated.camera_tracks import View, simulate_tracks
from tests.procedures.fusion.motions import CAMERA, GYRO_BIAS, NOISE, turned

SECONDS = 12.0
LATE = -0.08  # s to be added: the camera's stamps are late
Motion = Callable[[FloatArray], tuple[FloatArray, FloatArray]]  # t (n,) to rotation vectors and places (n, 3)


def rocking(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a flight that rests for 2 s, then swings about all axes."""
    s = np.maximum(t - 2.0, 0.0)
    turn = np.stack([0.3 * np.sin(1.5 * s), 0.2 * np.sin(2.1 * s), 0.5 * np.sin(0.9 * s)], axis=1)
    return turn, np.stack([0.8 * np.sin(s), 0.6 * s, 0.3 * np.sin(1.3 * s)], axis=1)


def along(rate: float, speed: float) -> Motion:
    """Return a steady turn about the vertical, or straight on."""

    def motion(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        zero = np.zeros_like(t)
        return np.stack([zero, rate * t, zero], axis=1), np.stack([zero, zero, speed * t], axis=1)

    return motion


def humming(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a swing to and fro, five times a second: it is the same every 0.2 s."""
    zero = np.zeros_like(t)
    return np.stack([0.04 * np.sin(10 * np.pi * t), zero, zero], axis=1), np.stack([zero, zero, t], axis=1)


def seen(
    motion: Motion, seed: int = 0, offset: float = LATE, view: View | None = None
) -> tuple[ImuSeries, FeatureTracks]:
    """Return gyro and tracks of a motion, the tracks' stamps off by ``offset`` [s]."""
    rng, t, h = np.random.default_rng(seed), np.arange(0.0, SECONDS, 0.005), 1e-3
    before, after = (Rotation.from_rotvec(motion(t + dt)[0]) for dt in (-h, h))
    omega = (before.inv() * after).as_rotvec() / (2 * h) + GYRO_BIAS
    omega += rng.normal(size=omega.shape) * NOISE.gyro / 0.005**0.5
    turn, p = motion(t[::4])
    path = Trajectory(t[::4], p, Rotation.from_rotvec(turn).as_quat())
    tracks = simulate_tracks(path, CAMERA, view or View(), seed)
    return ImuSeries(t, omega, np.zeros_like(omega)), replace(tracks, t=tracks.t - offset)


@pytest.mark.proof
@pytest.mark.parametrize("offset", [-0.2, LATE, 0.0, 0.15])
def test_the_offset_is_found_again_to_its_own_sigma(offset: float) -> None:
    for seed in range(2):
        found = camera_offset(*seen(rocking, seed, offset), CAMERA)
        assert isinstance(found, CameraTimeOffset), found
        assert found.std < 1.5e-3
        assert abs(found.offset - offset) < 4 * found.std


@pytest.mark.proof
def test_sigmas_are_what_the_errors_are() -> None:
    found = [camera_offset(*seen(rocking, seed, view=View(features=60)), CAMERA) for seed in range(10, 19)]
    ratio = np.array([(each.offset - LATE) / each.std for each in found if isinstance(each, CameraTimeOffset)])
    assert len(ratio) == len(found)
    assert 0.3 < np.sqrt(np.mean(ratio**2)) < 1.4


def test_neither_a_gyro_bias_nor_a_camera_specified_a_degree_wrong_moves_it() -> None:
    imu, tracks = seen(rocking)
    biased = replace(imu, omega_b=imu.omega_b + np.array([0.1, -0.1, 0.1]))
    for samples, camera in (
        (biased, CAMERA),
        (imu, turned(CAMERA, 1.0, 0.02)),
        (biased, turned(CAMERA, -1.0, 0.0)),
    ):
        found = camera_offset(samples, tracks, camera)
        assert isinstance(found, CameraTimeOffset), found
        assert abs(found.offset - LATE) < 4 * found.std


@pytest.mark.parametrize(
    "motion", [along(0.0, 0.0), along(0.0, 1.5), along(0.5, 1.5), humming],
    ids=["at rest", "straight on", "a steady turn", "the same every 0.2 s"],
)  # fmt: skip
def test_a_motion_that_determines_nothing_is_refused_and_says_what_to_do(motion: Motion) -> None:
    for seed in range(2):
        found = camera_offset(*seen(motion, seed), CAMERA)
        assert isinstance(found, Waiting), found
        assert "rotate it unevenly" in found.why


def test_a_camera_that_sits_otherwise_than_specified_is_refused() -> None:
    imu, tracks = seen(rocking)
    wrong = replace(CAMERA, C_bc=CAMERA.C_bc @ Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix())
    found = camera_offset(imu, tracks, wrong)
    assert isinstance(found, Waiting)
    assert "imu_from_camera" in found.why


def test_features_that_are_never_the_same_are_no_clock() -> None:
    imu, tracks = seen(rocking)
    strange = replace(tracks, uv=np.random.default_rng(5).permuted(tracks.uv, axis=0))
    assert isinstance(camera_offset(imu, strange, CAMERA), Waiting)
    new = replace(tracks, feature=np.arange(len(tracks.t)))
    found = camera_offset(imu, new, CAMERA)
    assert isinstance(found, Waiting)
    assert "0 pairs of frames" in found.why
