"""Tables of means with error terms: named, as large as planted, and the calibration right with them in."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.pose_tables import PoseDiagnosis, PoseTable, diagnose_poses
from procedures.free_positions.pose_means import MeansCalibration, calibrate_means

K = np.array([[1.0004, 0.0, 0.0], [3e-4, 0.9993, 0.0], [-2e-4, 4e-4, 1.0011]])
BIAS = np.array([1.2e-3, -0.8e-3, 2.1e-3])
NOISE = 2e-6  # g, of a mean


def outputs(seed: int, n: int = 40, **planted: FloatArray) -> FloatArray:
    """Return means (n, 3) [g] in attitudes drawn at random, with terms by name and sensor (3,)."""
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((n, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    terms = {"square": u**2, "size": np.abs(u), "cube": u**3, "product": u * np.roll(u, -1, axis=1)}
    added = sum((c * terms[name] for name, c in planted.items()), np.zeros((n, 3)))
    return u @ K.T + BIAS + added + NOISE * rng.standard_normal((n, 3))


def diagnosed(accel: FloatArray, *, is_std_stated: bool = True) -> tuple[PoseDiagnosis, MeansCalibration]:
    """Return what the table lacks, and the calibration with that in it."""
    std = np.full(accel.shape, NOISE if is_std_stated else 1e-9)
    table = PoseTable.of(accel, std, 1.0, is_std_stated=is_std_stated)
    assert table is not None
    found = diagnose_poses(table)
    effects = found.effects if found.findings else None
    fit = calibrate_means(
        found.accel if effects else accel, std, 1.0, 0.0, is_std_stated=is_std_stated, effects=effects
    )
    assert isinstance(fit, MeansCalibration)
    return found, fit


@pytest.mark.parametrize("is_std_stated", [True, False])
@pytest.mark.parametrize(
    ("effect", "planted", "value"),
    [
        ("accelerometer.quadratic", {"square": np.array([60e-6, 0.0, -40e-6])}, 60e-6),
        ("accelerometer.scale_asymmetry", {"size": np.array([80e-6, 50e-6, -40e-6])}, 160.0),
        ("accelerometer.cubic", {"cube": np.array([0.0, 70e-6, 0.0])}, 70e-6),
        ("accelerometer.cross_product", {"product": np.array([40e-6, 0.0, 0.0])}, 40e-6),
    ],
)
def test_a_nonlinearity_is_named_with_its_size(
    effect: str, planted: dict[str, FloatArray], value: float, *, is_std_stated: bool
) -> None:
    found, fit = diagnosed(outputs(3, **planted), is_std_stated=is_std_stated)
    (finding,) = found.findings
    assert finding.effect == effect
    assert finding.probability > 0.8
    largest = int(np.argmax(np.abs(finding.value)))
    assert finding.value[largest] == pytest.approx(value, abs=3.5 * finding.std[largest])
    (error,) = found.errors
    assert error.held_out_before is not None
    assert error.held_out_after is not None
    assert error.held_out_after < error.held_out_before
    assert np.max(np.abs(fit.bias - BIAS / np.linalg.norm(K, axis=1)) / fit.bias_std) < 4


@pytest.mark.parametrize("is_std_stated", [True, False])
def test_noise_has_no_name(*, is_std_stated: bool) -> None:
    for seed in range(5):
        found, _ = diagnosed(outputs(seed, 25), is_std_stated=is_std_stated)
        assert not found.findings
        assert not found.unnamed


def test_biases_have_their_uncertainty_with_an_effect_in_the_model() -> None:
    sigmas = list[FloatArray]()
    for seed in range(12):
        _, fit = diagnosed(outputs(seed, 30, square=np.array([60e-6, 0.0, -40e-6])))
        sigmas.append((fit.bias - BIAS / np.linalg.norm(K, axis=1)) / fit.bias_std)
    assert 0.5 < np.sqrt(np.mean(np.square(sigmas))) < 1.4


def test_poses_that_leave_no_residual_are_not_diagnosed() -> None:
    accel = outputs(1, 9)
    assert PoseTable.of(accel, np.full(accel.shape, NOISE), 1.0, is_std_stated=True) is None
