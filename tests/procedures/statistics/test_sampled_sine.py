import numpy as np
import pytest

from procedures.statistics.sampled_sine import sine, sine_sum, slowed

TURNS = 0.1234


@pytest.mark.parametrize("n", [1, 2, 120, 10_007])
def test_they_are_what_every_sample_by_itself_gives(n: int) -> None:
    wave, values = np.exp(2j * np.pi * TURNS * np.arange(n)), np.random.default_rng(1).normal(size=n)
    assert sine(n, TURNS, 2 - 1j) == pytest.approx(np.real((2 - 1j) * wave), abs=1e-11)
    assert sine_sum(values, TURNS) == pytest.approx(complex(values @ np.conj(wave)), abs=1e-9)


def test_parts_sums_tell_a_frequency_near_by() -> None:
    n, values = 10_007, np.random.default_rng(1).normal(size=10_007)
    middles, sums = slowed(values, TURNS, 1000)
    off = 1 / n
    told = complex(sums @ np.exp(-2j * np.pi * off * middles))
    noise = np.sqrt(n)  # 1 sigma of what noise of 1 does to a sum
    assert abs(told - sine_sum(values, TURNS + off)) < 4 * (2 / 1000) * noise
