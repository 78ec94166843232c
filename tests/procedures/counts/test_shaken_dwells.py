"""Which dwells shook: by others long enough to be compared, and never by short ones."""

import numpy as np
import pytest

from procedures.counts.shaken_dwells import shaken


def noise(seed: int, lengths: list[int]) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [10 * rng.standard_normal(n) for n in lengths]


@pytest.mark.parametrize(
    "lengths", [[5000] * 5, [300, *[5000] * 4], [300] * 3 + [5000] * 9, [20, 20, 5000], [20] * 4]
)
def test_dwells_of_one_noise_did_not_shake_however_short_some_are(lengths: list[int]) -> None:
    assert not any(shaken(noise(1, lengths), 0.0))


@pytest.mark.parametrize("short", [0, 3])
def test_the_dwell_that_shook_is_told_from_the_others(short: int) -> None:
    dwells = noise(2, [300] * short + [5000] * 6)
    dwells[-2] = dwells[-2] + 200 * np.sin(2 * np.pi * 0.05 * np.arange(5000))
    assert shaken(dwells, 0.0) == [False] * (short + 4) + [True, False]
