"""Signed integers printed as unsigned ones, and what only looks like them."""

import numpy as np
import pytest

from procedures.rest_plausibility import signed, unsigned_bits

DRAW = np.random.default_rng(7)
NEAR_ZERO = np.rint(DRAW.normal(-2, 5, 1000))


@pytest.mark.parametrize("bits", [8, 10, 12, 13, 14, 16, 18, 20, 24, 32])
def test_values_near_zero_jump_between_the_ends(bits: int) -> None:
    printed = NEAR_ZERO % 2**bits
    assert unsigned_bits(printed) == bits
    assert np.array_equal(signed(printed, bits), NEAR_ZERO)


@pytest.mark.parametrize(
    "values",
    [
        NEAR_ZERO,
        np.arange(200_000.0) * 37 % 65536,  # a counter that wraps
        np.rint(DRAW.uniform(0, 65535, 5000)),  # noise over the whole range
        np.rint(32768 + DRAW.normal(0, 5000, 5000)),  # offset binary
        np.full(1000, 65051.0),  # one level: gravity tells, not this
        np.where(np.arange(1000) == 500, 65535.0, 3.0),  # one damaged row
        np.array([65500.0, 65520.0, 65535.0, 10.0, 30.0]),  # a counter that wraps once
        NEAR_ZERO % 65536 + 0.5,
        np.rint(30000 * np.sin(np.arange(5000) / 50)) % 65536,  # a signal over the whole range, wrapped
        np.repeat([0.0, 250.0] * 5, 100) + np.arange(1000) % 2,  # a speed that steps, in deg/s
        np.repeat([0.0, 2000.0] * 5, 100) + np.arange(1000) % 3,
        np.repeat([0.0, 200.0] * 5, 100),
        np.repeat([0.0, 1.0, 0.0, 3.0] * 5, 100),  # few levels: no converter's
        np.array([0.0, 1e308, np.inf] * 5),
        np.empty(0),
    ],
)
def test_what_only_looks_like_it_is_left_alone(values: np.ndarray) -> None:
    assert unsigned_bits(values) is None
