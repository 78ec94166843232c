import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.sign_flip_test import MAX_P, sign_flip_p
from tests.procedures.diagnosis.redrawn import made_up, redrawn, seen_by, small


def eight_sigma(way: Candidate, sigmas: float = 8.0) -> FloatArray:
    """Return what a first coefficient of so many sigmas adds."""
    _, evidence, _ = seen_by("certified")
    std = np.sqrt(way.fit(evidence, (), np.ones(len(evidence.sigma))).coefficients()[1][0, 0])
    added: FloatArray = way.term.H[:, 0] * sigmas * std
    return added


@pytest.mark.parametrize("name", ["accelerometer.bias_drift", "accelerometer.relaxation", "gyroscope.magnetic"])
def test_an_effect_that_is_there_stands_out_from_its_flips(name: str) -> None:
    _, evidence, pool = seen_by("certified")
    way, rng = pool[name][0], np.random.default_rng(1)
    found = [sign_flip_p(redrawn(evidence, rng, eight_sigma(way, 12.0)), way, ()) for _ in range(12)]
    told = [p for p in found if p is not None]
    assert len(told) >= 9
    assert np.mean(np.array(told) <= MAX_P) >= 0.9
    assert min(told) >= 1 / 1000


@pytest.mark.parametrize("width", [1.0, 3.0])
def test_of_noise_of_any_width_a_twentieth_stands_out(width: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "procedures.diagnosis.sign_flip_test.MIN_POWER", 0.0
    )  # noise seldom looks like an effect to be told
    monkeypatch.setattr("procedures.diagnosis.sign_flip_test.FLIPS", 199)
    monkeypatch.setattr(
        "procedures.diagnosis.linear_model.WIDENED_LOG_P", -np.inf
    )  # a sigma that is wrong and stays so
    rng, found = np.random.default_rng(2), []
    for _ in range(300):
        evidence = small(rng, 20)  # a fit with few rows to spare, as a campaign's is
        evidence.residual[:] *= width * rng.standard_t(4, 36)  # and tails that are not normal
        found.append(sign_flip_p(evidence, made_up(evidence, rng.standard_normal((36, 2))), ()))
    p = np.array([each for each in found if each is not None])
    assert len(p) == 300
    assert np.mean(p <= 0.05) < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 300)
    assert np.mean(p <= 0.5) == pytest.approx(0.5, abs=0.12)
