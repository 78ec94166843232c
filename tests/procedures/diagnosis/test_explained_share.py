"""A term that makes the error on held-out data worse explains nothing, however little it is determined."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.explained_share import share_of_fits
from procedures.diagnosis.linear_model import Term, fit_linear
from tests.procedures.diagnosis.redrawn import small

ROWS = 36


def share(residual: FloatArray, column: FloatArray) -> float | None:
    evidence = replace(small(np.random.default_rng(0), 1), residual=residual, A=np.full((ROWS, 1), 1e-9))
    as_is, groups = np.ones(ROWS), [np.array([row]) for row in range(ROWS)]
    term = Term(column[:, None], np.array([1e3]))
    before, after = (fit_linear(evidence, terms, factor=as_is) for terms in ([], [term]))
    return share_of_fits(evidence, before, after, groups)


@pytest.mark.parametrize("size", [3.0, 10.0, 100.0])
def test_what_the_others_predict_is_explained(size: float) -> None:
    rng = np.random.default_rng(1)
    column = np.linspace(-1, 1, ROWS)
    found = share(size * column + rng.standard_normal(ROWS), column)
    assert found is not None
    assert found > 1 - 2 / size


@pytest.mark.parametrize("seed", range(5))
def test_a_term_of_the_wrong_shape_explains_next_to_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x = np.linspace(-1, 1, ROWS)
    assert (share(5 * x + rng.standard_normal(ROWS), np.cos(np.pi * x)) or 0.0) < 0.1
