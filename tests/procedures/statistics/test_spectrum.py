import numpy as np
import pytest
from scipy import signal

from procedures.statistics.spectrum import (
    lines_of,
    sine,
    sine_sum,
    slowed,
    spectrum_of,
    welch,
    without_lines,
    without_straight_line,
)

N, PERIOD = 20_000, 0.01


def test_the_density_integrates_to_the_variance_and_is_flat_for_white_noise() -> None:
    rate = np.random.default_rng(1).normal(scale=3.0, size=N)
    found = spectrum_of(rate, PERIOD)
    # one-sided: 2 sigma^2 dt = 0.18; its mean over the frequencies has 2 N / 2 degrees of freedom
    assert np.mean(found.density) == pytest.approx(0.18, rel=4 * np.sqrt(2 / N))
    assert np.std(found.density) / np.mean(found.density) == pytest.approx(np.sqrt(2 / found.dof), rel=0.1)


@pytest.mark.parametrize(("n", "segment"), [(64, 64), (101, 101), (1000, 101), (5000, 512), (4999, 2048)])
def test_the_density_is_that_of_the_library(n: int, segment: int) -> None:
    rate = np.random.default_rng(n).standard_normal(n) + np.arange(n) / n
    expected = signal.welch(rate, 50.0, "hann", segment, detrend=without_straight_line)
    for got, reported in zip(welch(rate, 0.02, segment), expected, strict=True):
        assert np.allclose(got, reported, rtol=1e-12, atol=0.0)


@pytest.mark.parametrize("colour", [0, 1])  # white, and a random walk over white
def test_noise_has_no_lines(colour: int) -> None:
    for seed in range(40):
        rng = np.random.default_rng(seed)
        rate = rng.normal(size=N)
        assert not lines_of(np.cumsum(rate) + 0.1 * rng.normal(size=N) if colour else rate, PERIOD)


def test_a_line_is_found_with_an_amplitude_and_a_frequency_within_their_sigmas() -> None:
    errors = list[tuple[float, float]]()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        hertz = 7.3 + rng.uniform()
        sine = 0.15 * np.cos(2 * np.pi * hertz * PERIOD * np.arange(N) + rng.uniform(0, 6))
        (line,) = lines_of(rng.normal(size=N) + sine, PERIOD)
        errors.append(((line.amplitude - 0.15) / line.amplitude_std, (line.hertz - hertz) / line.hertz_std))
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert np.all((rms > 0.4) & (rms < 1.4))  # 1 expected, the frequency's sigma is on the safe side


def test_a_line_above_half_the_sample_rate_shows_at_its_alias() -> None:
    rate = np.random.default_rng(1).normal(size=N) + np.cos(2 * np.pi * 113.0 * PERIOD * np.arange(N))
    assert lines_of(rate, PERIOD)[0].hertz == pytest.approx(13.0, abs=0.001)


def test_what_is_left_without_its_lines_has_none() -> None:
    rate = np.random.default_rng(1).normal(size=N) + np.cos(2 * np.pi * 13.0 * PERIOD * np.arange(N))
    assert not lines_of(without_lines(rate, PERIOD, lines_of(rate, PERIOD)), PERIOD)


TURNS = 0.1234


@pytest.mark.parametrize("n", [1, 2, 120, 10_007])
def test_they_are_what_every_sample_by_itself_gives(n: int) -> None:
    wave, values = np.exp(2j * np.pi * TURNS * np.arange(n)), np.random.default_rng(1).normal(size=n)
    assert sine(n, TURNS, 2 - 1j) == pytest.approx(np.real((2 - 1j) * wave), abs=1e-11)
    assert sine_sum(values, TURNS) == pytest.approx(complex(values @ np.conj(wave)), abs=1e-9)


def test_parts_sums_determine_a_frequency_near_by() -> None:
    n, values = 10_007, np.random.default_rng(1).normal(size=10_007)
    middles, sums = slowed(values, TURNS, 1000)
    off = 1 / n
    reported = complex(sums @ np.exp(-2j * np.pi * off * middles))
    noise = np.sqrt(n)  # 1 sigma of what noise of 1 does to a sum
    assert abs(reported - sine_sum(values, TURNS + off)) < 4 * (2 / 1000) * noise
