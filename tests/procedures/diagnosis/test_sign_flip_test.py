import numpy as np
import pytest

from procedures.diagnosis.sign_flip_test import sign_flip_p
from tests.procedures.diagnosis.redrawn import made_up, small


@pytest.mark.parametrize("width", [3.0])
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
