"""Which declared effects are one in a design: what adds no more than the other, not the other way round."""

import numpy as np

from procedures.diagnosis.declared_effects import are_one
from tests.procedures.diagnosis.redrawn import made_up, small


def test_what_adds_a_column_more_is_not_one_with_what_lacks_it() -> None:
    rng = np.random.default_rng(3)
    evidence, H = small(rng), rng.standard_normal((36, 2))
    less, more = made_up(evidence, H[:, :1]), made_up(evidence, H)
    assert are_one(evidence, less, more)
    assert not are_one(evidence, more, less)
    assert are_one(evidence, more, made_up(evidence, H @ [[1.0, 2.0], [0.5, -1.0]]))
    assert not are_one(evidence, more, made_up(evidence, rng.standard_normal((36, 2))))


def test_what_the_model_holds_already_is_one_with_nothing() -> None:
    rng = np.random.default_rng(4)
    evidence = small(rng)
    held = made_up(evidence, evidence.A[:, :1])
    assert not are_one(evidence, held, held)
