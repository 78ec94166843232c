import numpy as np
import pytest

from procedures.counts.dwell_means import estimate_rates


@pytest.mark.parametrize("seed", range(2))
def test_the_mean_of_white_noise_is_as_good_as_its_sigma_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    z, sigmas = [], []
    for _ in range(200):
        got = estimate_rates([5.0 + 0.3 * rng.standard_normal(2000)], 0.02)[0]
        z.append((got.rate - 5.0) / got.std)
        sigmas.append(got.std)
    assert 0.8 < np.std(z) < 1.2  # 4 sigma of an rms of 200
    assert 0.97 < np.mean(sigmas) / (0.3 / np.sqrt(2000)) < 1.03  # each known to 8 %, 200 of them to 0.6 %


def test_noise_that_is_not_white_widens_the_sigma() -> None:
    rng = np.random.default_rng(3)
    z = []
    for _ in range(100):
        smooth = np.convolve(rng.standard_normal(5100), np.ones(20) / 20, mode="valid")[:5000]
        got = estimate_rates([smooth], 0.02)[0]
        z.append(got.rate / got.std)
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.25  # single samples alone would make this 20


def test_slope_and_curvature_are_found_in_their_units() -> None:
    period, n = 0.02, 3000
    t = (np.arange(n) + 0.5 - n / 2) * period
    noise = 1e-4 * np.random.default_rng(4).standard_normal(n)
    got = estimate_rates([7.0 + 0.01 * t + 0.5 * 2e-4 * (t**2 - np.mean(t**2)) + noise], period)[0]
    assert abs(got.rate - 7.0) < 4 * got.std
    # a trend looks like noise between blocks, so the sigmas are far wider than the error: 1 % is the claim
    assert got.slope == pytest.approx(0.01, rel=1e-2)
    assert got.curvature == pytest.approx(2e-4, rel=1e-2)


def test_slope_and_curvature_have_honest_sigmas() -> None:
    rng = np.random.default_rng(5)
    found = [estimate_rates([rng.standard_normal(1000)], 0.02)[0] for _ in range(200)]
    for name in ("slope", "curvature"):
        z = [getattr(each, name) / getattr(each, f"{name}_std") for each in found]
        assert 0.8 < np.std(z) < 1.2  # 4 sigma of an rms of 200


def test_white_noise_is_given_per_root_second() -> None:
    got = estimate_rates([0.5 * np.random.default_rng(6).standard_normal(20000)], 0.01)[0]
    assert 0.7 < got.noise / (0.5 * np.sqrt(0.01)) < 1.3  # 4 sigma of what 128 blocks know
