"""Lines that pass every count's interval, against shapes known by hand and a count of random lines."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.count_propagation import rate_within_counts
from procedures.counts.dwell_means import shaken

N = 160


def nodes(rate: float, remainder: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, lows and links of a noise-free counter that began with a remainder."""
    t = np.arange(N + 1.0)
    return t, np.floor(remainder + rate * t), np.r_[0.0, np.ones(N)]


def test_a_count_that_stands_still_leaves_a_triangle() -> None:
    found = rate_within_counts(*nodes(0.0, 0.5), 0.0, 0.4 / N)
    assert found is not None
    assert np.array(found) * N == pytest.approx([0.0, 2 / np.sqrt(24)], abs=2e-3)  # as wide as two counts


def test_a_pattern_of_two_that_slips_once_leaves_a_ramp() -> None:
    """A slip's moment is known, and a rate is as likely as it is large: 2/3 of the width."""
    t, low, linked = nodes(0.5, 0.25)
    low[t > 115] += np.where(t[t > 115] % 2, 1, 0)  # after this sample odd nodes are a count higher
    found = rate_within_counts(t, low, linked, 0.5, 0.3 / N)
    assert found is not None
    width = 0.5 / 115  # half a count in the longer of the two parts
    assert found[0] - 0.5 == pytest.approx(2 / 3 * width, rel=0.03)
    assert found[1] == pytest.approx(width / np.sqrt(18), rel=0.03)


@pytest.mark.parametrize("rate", [1 / 3 + 0.1 / N, 0.25 - 0.05 / N, 0.5 + 0.3 / N])
def test_it_is_what_random_lines_say(rate: float) -> None:
    rng = np.random.default_rng(3)
    t, low, linked = nodes(rate, 0.41)
    slopes, levels = rate + rng.uniform(-0.6, 0.6, 100_000) / N, rng.uniform(0, 0.8, 100_000)
    bottom, top = np.full(len(slopes), -np.inf), np.full(len(slopes), np.inf)
    for at, count in zip(t, low, strict=True):
        np.maximum(bottom, count - slopes * at, out=bottom)
        np.minimum(top, count + 1 - slopes * at, out=top)
    fits = slopes[(bottom <= levels) & (levels < top)]
    found = rate_within_counts(t, low, linked, rate, 0.25 / N)
    assert found is not None
    assert len(fits) > 100
    assert abs(found[0] - fits.mean()) < 4 * found[1] / np.sqrt(len(fits))
    assert found[1] == pytest.approx(fits.std(), rel=4 / np.sqrt(2 * len(fits)))


# Dwells that shook


def noise(seed: int, lengths: list[int]) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [10 * rng.standard_normal(n) for n in lengths]


@pytest.mark.parametrize(
    "lengths", [[5000] * 5, [300, *[5000] * 4], [300] * 3 + [5000] * 9, [20, 20, 5000], [20] * 4]
)
def test_dwells_of_one_noise_did_not_shake_however_short_some_are(lengths: list[int]) -> None:
    assert not any(shaken(noise(1, lengths), 0.0))


@pytest.mark.parametrize("short", [0, 3])
def test_the_dwell_that_shook_is_distinguished_from_the_others(short: int) -> None:
    dwells = noise(2, [300] * short + [5000] * 6)
    dwells[-2] = dwells[-2] + 200 * np.sin(2 * np.pi * 0.05 * np.arange(5000))
    assert shaken(dwells, 0.0) == [False] * (short + 4) + [True, False]
