"""Factors of normal equations: what they solve, against the inverse; keyframes in a chain as any matrix."""

from types import SimpleNamespace

import numpy as np
import pytest

from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.inner.window_factor import ChainFactor, Factor
from procedures.fusion.inner.window_state import COMMON, FRAME
from tests.procedures.fusion.inner.test_wheel import run


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
    with pytest.raises(np.linalg.LinAlgError, match=f"singular from unknown {unknown + 1} on"):
        kind(A)


def test_what_is_common_may_be_what_is_not_known() -> None:
    A = chained(3, 6)
    A[0], A[:, 0] = A[1], A[:, 1]
    A[0, 0] = A[1, 0] * (1 - 1e-9)
    with pytest.raises(np.linalg.LinAlgError, match="singular from unknown 2 on"):
        ChainFactor(A)


def test_a_window_with_fixes_and_a_wheel_is_a_chain() -> None:
    window, _ = run(True, True)
    A = window._problem(window.state, window._prior, window._held)[0].A  # noqa: SLF001
    chain, size = window._factorised(A), 1 / np.sqrt(np.diag(A))  # noqa: SLF001
    assert type(chain) is ChainFactor
    right = np.random.default_rng(2).normal(size=len(A)) / size
    off = (chain.solve(right) - Factor(A).solve(right)) / size
    assert np.abs(off).max() < 1e-6 * np.abs(chain.solve(right) / size).max()


@pytest.mark.parametrize(
    ("marks", "held", "keyframes", "kind"),
    [(0, 0, 2, ChainFactor), (0, 0, 3, Factor), (1, 0, 1, Factor), (0, 1, 1, Factor)],
)
def test_what_ties_more_than_neighbours_is_no_chain(marks: int, held: int, keyframes: int, kind: type) -> None:
    """Sights, landmarks that the prior holds, and a prior of three keyframes do."""
    window = SimpleNamespace(
        marks=SimpleNamespace(slot=np.zeros(marks)), state=SimpleNamespace(held=np.zeros((held, 3))),
        _prior=SimpleNamespace(at=SimpleNamespace(p=np.zeros((keyframes, 3)))),
    )  # fmt: skip
    assert type(InnerWindow._factorised(window, chained(3, 1))) is kind  # type: ignore[arg-type]  # noqa: SLF001
