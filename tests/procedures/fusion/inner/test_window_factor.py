"""Factors of normal equations: what they solve, against the inverse; keyframes in a chain as any matrix."""

import numpy as np
import pytest

from procedures.fusion.inner.window_factor import ChainFactor, Factor
from procedures.fusion.inner.window_state import COMMON, FRAME
from tests.refusals import refused


def chained(keyframes: int, seed: int) -> np.ndarray:
    """Return normal equations (n, n) of keyframes tied to the next and to what is common; units differ by 1e6."""
    rng, n = np.random.default_rng(seed), COMMON + FRAME * keyframes
    A = np.diag(rng.uniform(1, 2, n))
    for k in range(max(keyframes - 1, 1)):
        at = np.r_[:COMMON, COMMON + FRAME * k : min(COMMON + FRAME * (k + 2), n)]
        J = rng.normal(size=(20, len(at)))
        A[np.ix_(at, at)] += J.T @ J
    unit = 10 ** rng.uniform(-3, 3, n)
    return A * unit * unit[:, None]


@pytest.mark.parametrize("kind", [Factor, ChainFactor])
@pytest.mark.parametrize("keyframes", [1, 2, 3, 20])
def test_it_solves_and_has_the_inverse_s_blocks(kind: type[Factor], keyframes: int) -> None:
    A = chained(keyframes, keyframes)
    factor, inverse, rng = kind(A), np.linalg.inv(A), np.random.default_rng(1)
    size = np.sqrt(np.diag(inverse))
    for right in (rng.normal(size=len(A)), rng.normal(size=(len(A), 3))):
        scaled = (right.T / size).T
        expected = inverse @ scaled
        assert np.abs((factor.solve(scaled) - expected).T / size).max() < 1e-9 * np.abs(expected.T / size).max()
    for at in (slice(0, 3), slice(COMMON - 2, COMMON + 4), slice(len(A) - FRAME, len(A))):
        each = np.outer(size[at], size[at])
        assert np.allclose(factor.covariance(at) / each, inverse[at, at] / each, atol=1e-9)
    assert factor.size == len(A)


@pytest.mark.parametrize("unknown", [COMMON + FRAME - 1, COMMON + 3 * FRAME - 1])
@pytest.mark.parametrize("kind", [Factor, ChainFactor])
def test_what_nothing_is_known_of_is_named(kind: type[Factor], unknown: int) -> None:
    A = chained(4, 5)
    A[unknown], A[:, unknown] = A[unknown - 1], A[:, unknown - 1]
    A[unknown, unknown] = A[unknown, unknown - 1] * (1 - 1e-9)  # their difference is open
    with refused(np.linalg.LinAlgError, None, f"unknown {unknown + 1} "):
        kind(A)
