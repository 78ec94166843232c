"""Probabilities are shares: of draws from the prior, of copies, and whatever the order of hypotheses."""

from itertools import pairwise

import numpy as np
import pytest

from procedures.inference.posterior import posterior
from procedures.inference.search import Search
from tests.procedures.inference.boards import board

M, HYPOTHESES, ODDS = 12, 8, 0.15
BINS = (0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 0.99, 1.0)
AMPLITUDES = np.geomspace(0.3, 10.0, 25)


def probabilities(y: np.ndarray, columns: list[list[np.ndarray]]) -> np.ndarray:
    search = Search(board(y, columns, AMPLITUDES, float(np.log(ODDS))))
    search.run()
    found = posterior(search).probabilities
    return np.array([found[f"h{i}"] for i in range(len(columns))])


def drawn(rng: np.random.Generator) -> tuple[np.ndarray, list[list[np.ndarray]], np.ndarray]:
    """Draw columns that overlap, which of them act by the prior, and what they make of noise."""
    common = rng.standard_normal((M, 3))
    columns = [
        [common @ rng.standard_normal((3, k)) + 0.5 * rng.standard_normal((M, k)) for _ in range(2)]
        for k in rng.integers(1, 3, HYPOTHESES).tolist()
    ]
    acts, y = rng.random(HYPOTHESES) < ODDS / (1 + ODDS), rng.standard_normal(M)
    for i in np.flatnonzero(acts).tolist():
        W = columns[i][int(rng.integers(2))]
        y += rng.choice(AMPLITUDES) * W @ rng.standard_normal(W.shape[1])
    return y, columns, acts


@pytest.mark.parametrize("draws", [50, pytest.param(2000, marks=pytest.mark.proof)])
def test_of_draws_from_the_prior_a_probability_is_the_share_that_acts(draws: int) -> None:
    rng = np.random.default_rng(11)
    stated, true = list[float](), list[bool]()
    for _ in range(draws):
        y, columns, acts = drawn(rng)
        stated += probabilities(y, columns).tolist()
        true += acts.tolist()
    p, is_true = np.array(stated), np.array(true)
    for low, high in pairwise(BINS):
        inside = (p >= low) & (p <= high)
        if not inside.any():
            continue
        expected = float(np.mean(p[inside]))
        sigma = np.sqrt(expected * (1 - expected) / np.sum(inside))
        assert float(np.mean(is_true[inside])) == pytest.approx(expected, abs=3 * sigma + 0.01)


def test_no_probability_is_above_one() -> None:
    rng = np.random.default_rng(4)
    for _ in range(10):  # odds of exp(1e8) are differences of large logarithms, which round
        y, columns, _ = drawn(rng)
        search = Search(board(1e4 * y, columns, 1e4 * AMPLITUDES, float(np.log(ODDS))))
        search.run()
        found = posterior(search)
        every = [*found.probabilities.values()]
        for one in found.causes:
            every += [one.probability, one.joint, one.nameless, *one.shares.values()]
        assert max(every) <= 1.0
        assert max(every) > 0.99


def test_the_order_of_hypotheses_does_not_matter() -> None:
    rng = np.random.default_rng(12)
    for _ in range(20):
        y, columns, _ = drawn(rng)
        order = rng.permutation(HYPOTHESES)
        again = probabilities(y, [columns[i] for i in order])
        assert again == pytest.approx(probabilities(y, columns)[order], abs=1e-9)


def test_what_cannot_be_separated_shares_equally() -> None:
    rng = np.random.default_rng(13)
    W = rng.standard_normal((M, 1))
    search = Search(board(8 * W[:, 0] / np.linalg.norm(W), [[W], [W.copy()]], AMPLITUDES, float(np.log(0.01))))
    search.run()
    (cause,) = posterior(search).causes
    assert cause.joint > 0.99
    assert cause.shares == pytest.approx({"h0": 0.5, "h1": 0.5}, abs=0.01)


def test_what_the_model_takes_wholly_keeps_its_prior() -> None:
    y = np.random.default_rng(14).standard_normal(M)
    found = probabilities(y, [[np.zeros((M, 1))]])
    assert found == pytest.approx([ODDS / (1 + ODDS)], rel=1e-9)
