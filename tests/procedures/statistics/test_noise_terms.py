import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.statistics.allan_deviation import TERMS, fit_noise, overlapping_deviation


@pytest.mark.parametrize("seed", range(2))
def test_planted_noise_terms_are_read_off_within_their_limits(seed: int) -> None:
    rng, n, period = np.random.default_rng(seed), 100_000, 0.02
    white = rng.normal(scale=3e-3 / np.sqrt(period), size=n)
    walk = np.cumsum(rng.normal(scale=2e-4 * np.sqrt(period), size=n))
    quantised = np.diff(rng.uniform(-0.5, 0.5, size=n + 1)) * 1e-3 / period
    terms = fit_noise(overlapping_deviation(white + walk + quantised, period)).terms
    assert terms["random_walk"].value == pytest.approx(3e-3, rel=0.1)
    assert terms["rate_random_walk"].value == pytest.approx(2e-4, rel=0.5)
    assert terms["quantisation"].value == pytest.approx(1e-3 / np.sqrt(12), rel=0.05)
    assert all(term.low <= (term.value or 0) <= term.high for term in terms.values())


def test_a_term_that_is_not_seen_is_bounded_and_not_valued() -> None:
    terms = fit_noise(overlapping_deviation(np.random.default_rng(3).normal(size=5000), 0.02)).terms
    assert terms["rate_random_walk"].value is None
    assert terms["rate_random_walk"].high > 0


def test_a_pulse_train_without_noise_has_no_random_walk() -> None:
    counts = np.diff(np.floor(20.8837 * np.arange(5001)))
    terms = fit_noise(overlapping_deviation(counts / 0.02, 0.02), quantum=1.0).terms
    assert [name for name, term in terms.items() if term.value is not None] in ([], ["quantisation"])


def _flicker(n: int, rng: np.random.Generator) -> FloatArray:
    """Noise of spectrum B^2 / (2 pi f), B = 1: white through half an integrator (Kasdin, Proc. IEEE 1995)."""
    k = np.arange(1, n)
    h = np.concatenate(([1.0], np.cumprod((k - 0.5) / k)))
    product = np.fft.rfft(h, 2 * n) * np.fft.rfft(rng.normal(size=n), 2 * n)
    return np.asarray(np.fft.irfft(product, 2 * n)[:n])


def _simulated(seed: int, n: int, period: float, N: float, B: float, K: float) -> FloatArray:
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(size=n)) * K * np.sqrt(period)
    return N / np.sqrt(period) * rng.normal(size=n) + B * _flicker(n, rng) + walk


@pytest.mark.parametrize(("N", "B", "K"), [(1.0, 0.0, 0.05), (1.0, 0.3, 0.0)])
def test_simulated_terms_come_back_within_their_own_sigma(N: float, B: float, K: float) -> None:
    planted = {"random_walk": N, "bias_instability": B, "rate_random_walk": K}
    errors: dict[str, list[float]] = {name: [] for name, size in planted.items() if size}
    for seed in range(20):
        terms = fit_noise(overlapping_deviation(_simulated(seed, 50_000, 0.02, N, B, K), 0.02)).terms
        for name in errors:
            if (value := terms[name].value) is not None:
                errors[name].append((value - planted[name]) / ((terms[name].high - terms[name].low) / 3.92))
    for name, found in errors.items():
        assert len(found) >= 12, name  # at times a short walk looks like a ramp, or like flicker
        assert np.sqrt(np.mean(np.square(found))) < 1.5, name  # 1 expected; of 12 values 1.5 is beyond 99.9 %
    assert 0.6 < np.sqrt(np.mean(np.square(errors["random_walk"]))) < 1.5


def test_white_noise_has_no_other_term() -> None:
    for seed in range(20):
        terms = fit_noise(overlapping_deviation(_simulated(seed, 20_000, 0.02, 1.0, 0.0, 0.0), 0.02)).terms
        assert [name for name in TERMS if terms[name].value is not None] == ["random_walk"]


def test_a_ramp_is_determined_by_its_coefficient() -> None:
    rate = np.random.default_rng(1).normal(size=50_000) + 2e-2 * np.arange(50_000) * 0.02
    term = fit_noise(overlapping_deviation(rate, 0.02)).terms["rate_ramp"]
    assert term.low < 2e-2 < term.high
