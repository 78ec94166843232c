"""How many harmonics a periodic error has follows from the data, and a table tells what is left."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from procedures.arrays import FloatArray
from procedures.diagnosis.sample_effects import SampleEffects, sample_effects
from tests.procedures.diagnosis.test_sample_effects import UNIT, N, soak

LEVELS = np.random.default_rng(5).normal(size=24)
SHAPES: dict[str, tuple[Callable[[FloatArray], FloatArray], float]] = {
    "one": (lambda p: np.cos(2 * np.pi * p), 0.3),
    "two": (lambda p: np.cos(2 * np.pi * p) + 0.5 * np.sin(4 * np.pi * p), 0.3),
    "twelfth": (lambda p: np.cos(2 * np.pi * 12 * p) + np.cos(2 * np.pi * p), 0.4),
    "thirty-second": (lambda p: np.cos(2 * np.pi * 32 * p) + 0.5 * np.cos(2 * np.pi * p), 0.5),
    "reset": (lambda p: (p < 0.05) * 1.0, 3.0),
    "short reset": (lambda p: (p < 0.02) * 1.0, 4.0),
    "triangle": (lambda p: np.abs(p - 0.5), 2.0),
    "saw and third": (lambda p: (p - 0.5) + 0.5 * np.cos(6 * np.pi * p), 1.0),
    "half and half": (lambda p: np.sign(p - 0.5), 0.5),
    "levels": (lambda p: LEVELS[(24 * p).astype(int)], 0.6),
}


def ramp(seed: int) -> FloatArray:
    """Return a phase (n,) that passes all values in an irregular order."""
    return np.cumsum(0.037 * (1 + 0.1 * np.random.default_rng(seed).normal(size=N))) % 1.0


def found(error: FloatArray, phase: FloatArray, seed: int = 1) -> SampleEffects:
    gyro = np.random.default_rng(seed).normal(size=(N, 3))
    gyro[:, 2] += error
    return sample_effects([soak(gyro, ramp=360 * phase)], UNIT)


@pytest.mark.parametrize("name", SHAPES)
def test_the_error_on_held_out_samples_is_that_of_noise_alone(name: str) -> None:
    shape, size = SHAPES[name]
    error = size * shape(ramp(2))
    told = found(error, ramp(2))
    left = float(np.prod([1 - each.share for each in told.findings if each.share is not None]))
    assert left == pytest.approx(1 / (1 + np.var(error)), abs=0.025)
    assert not told.left


@pytest.mark.parametrize(("harmonics", "order"), [((1,), 1), ((1, 2), 2), ((1, 3), 3), ((2, 12), 12)])
def test_the_order_is_that_of_the_highest_harmonic(harmonics: tuple[int, ...], order: int) -> None:
    phase = ramp(3)
    (finding,) = found(0.3 * np.sum([np.cos(2 * np.pi * h * phase) for h in harmonics], axis=0), phase).findings
    assert len(finding.coefficients) == 2 * order
    errors = (
        finding.value / 3600 - [0.3 * (i % 2 == 0 and i // 2 + 1 in harmonics) for i in range(2 * order)]
    ) / (finding.std / 3600)
    assert np.abs(errors).max() < 4.5


@pytest.mark.parametrize("colour", [0.0, 0.9, 0.99])
def test_noise_of_any_colour_has_no_order_and_leaves_nothing(colour: float) -> None:
    rng = np.random.default_rng(6)
    gyro = lfilter([np.sqrt(1 - colour**2)], [1.0, -colour], rng.normal(size=(N, 3)), axis=0)
    told = sample_effects([soak(gyro, ramp=360 * ramp(7))], UNIT)
    assert told.findings == ()
    assert told.left == ()
