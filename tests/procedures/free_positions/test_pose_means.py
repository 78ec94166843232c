"""Means of poses: what is planted comes back within its sigma, and few rows that differ like poses are known."""

import numpy as np
import pytest
from scipy.stats import t as student_t

from procedures.arrays import FloatArray
from procedures.free_positions.norm_fit import Undetermined
from procedures.free_positions.pose_means import (
    ONE_SIGMA,
    MeansCalibration,
    calibrate_means,
    gyro_bias,
    widened,
)

K = np.array([[1.02, 0, 0], [0.006, 0.98, 0], [-0.004, 0.003, 1.01]])
BIAS = np.array([0.02, -0.03, 0.01])
NOISE = 2e-4  # g
SIX = np.concatenate((np.eye(3), -np.eye(3)))


def directions(n: int, seed: int) -> FloatArray:
    u = np.random.default_rng(seed).normal(size=(n, 3))
    found: FloatArray = u / np.linalg.norm(u, axis=1)[:, None]
    return found


def outputs(u: FloatArray, seed: int, noise: float = NOISE) -> FloatArray:
    found: FloatArray = u @ K.T + BIAS + noise * np.random.default_rng(seed + 1000).normal(size=u.shape)
    return found


def calibrated(accel: FloatArray, std: float, *, stated: bool) -> MeansCalibration:
    found = calibrate_means(accel, np.full(accel.shape, std), 1.0, 0.0, is_std_stated=stated)
    assert isinstance(found, MeansCalibration)
    return found


@pytest.mark.proof
@pytest.mark.parametrize(("n", "stated"), [(14, True), (14, False), (24, True), (24, False)])
def test_sigmas_hold_what_was_planted(n: int, stated: bool) -> None:
    """Over 20 tables the errors in sigmas are those of a normal distribution; of few poses sigmas are wider."""
    k, E = np.linalg.norm(K, axis=1), K / np.linalg.norm(K, axis=1)[:, None]
    off, lower = list[FloatArray](), np.tril_indices(3, -1)
    for seed in range(20):
        found = calibrated(outputs(directions(n, seed), seed), NOISE if stated else 1e-9, stated=stated)
        if found.not_observable:
            continue
        off.append((found.k - k) / found.k_std)
        off.append((found.bias - BIAS / k) / found.bias_std)
        off.append((found.E[lower] - E[lower]) / found.E_std[lower])
    beyond = np.abs(np.concatenate(off))
    assert len(beyond) > 100
    assert 0.55 < np.mean(beyond < 1) < (0.95 if n < 20 else 0.85)  # 0.68; of few poses the jackknife is wider
    assert np.mean(beyond > 3) < 0.02


def test_six_faces_give_no_misalignment_and_without_stated_noise_no_sigma() -> None:
    u = SIX + 0.02 * directions(6, 3)
    accel = outputs(u / np.linalg.norm(u, axis=1)[:, None], 3)
    stated = calibrated(accel, NOISE, stated=True)
    assert stated.not_observable == ("misalignment.yx", "misalignment.zx", "misalignment.zy")
    assert np.all(np.abs(stated.bias - BIAS / np.linalg.norm(K, axis=1)) < 4 * stated.bias_std)
    assert np.isnan(stated.held_out).all()
    assert np.isnan(calibrated(accel, 1e-6, stated=False).k_std).all()


@pytest.mark.parametrize("n", [2, 4, 5])
def test_too_few_poses_are_refused_with_what_is_missing(n: int) -> None:
    found = calibrate_means(outputs(SIX[:n], 1), np.full((n, 3), NOISE), 1.0, 0.0, is_std_stated=True)
    assert isinstance(found, Undetermined)
    assert found.missing


@pytest.mark.parametrize("free", [0.0, 0.5, 0.999, 1.001, 4.0])
def test_noise_that_is_stated_is_not_widened_and_scatter_is_by_its_share(free: float) -> None:
    assert widened(free, 0.0) == 1
    t = max(1.0, free)
    assert widened(free, 0.5) ** 2 == pytest.approx((1 + student_t.ppf(ONE_SIGMA, t) ** 2) / 2)
    assert np.isnan(widened(free, 1.0)) == (free < 1)


def test_the_mean_of_gyroscopes_at_rest() -> None:
    gyro = np.array([0.1, -0.2, 0.3]) + 0.01 * np.random.default_rng(2).normal(size=(20, 3))
    value, std = gyro_bias(gyro, np.full(gyro.shape, 1e-6))
    assert std == pytest.approx(0.01 / np.sqrt(20), rel=0.5)
    assert np.all(np.abs(value - [0.1, -0.2, 0.3]) < 4 * std)
