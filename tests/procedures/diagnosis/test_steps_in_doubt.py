"""What may hang on one step, steps that stand near each other, and curves as terms: reckoned by hand."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.diagnosis.outdone import curves_term, of_one_step_in_doubt
from procedures.diagnosis.result import Finding
from tests.procedures.diagnosis.found_already import adopted
from tests.procedures.diagnosis.redrawn import made_up, small

EVIDENCE = small(np.random.default_rng(1))


def test_curves_are_one_sigma_over_all_rows_and_what_is_nought_is_left_out() -> None:
    H = np.array([[3.0, 0.0, 0.0], [4.0, 0.0, -2.0]])
    term = curves_term(H, np.array([0.5, 2.0]), 7.0)
    assert term.H == pytest.approx(np.array([[0.3, 0.0], [1.6, -2.0]]))
    assert term.plausible == pytest.approx([7.0, 7.0])


@pytest.mark.parametrize(
    ("where", "hangs", "confidence"),
    [
        ({}, False, "likely"),
        ({}, True, "ambiguous"),
        ({"position": 3}, False, "ambiguous"),
        ({"in": "x"}, False, "likely"),
    ],
)
def test_what_one_step_may_tell_is_in_doubt(where: dict[str, object], hangs: bool, confidence: str) -> None:
    way = made_up(EVIDENCE, np.ones((36, 1)))
    way = replace(
        way, effect=replace(way.effect, may_hang_on_a_step=hangs), columns=replace(way.columns, where=where)
    )
    finding = Finding(
        "a", "instrument", ("x",), np.ones(1), np.ones(1), "g", {}, "likely", (), "", -9.0, 5.0
    )  # fmt: skip
    other = made_up(EVIDENCE, np.ones((36, 1)))
    first, second = of_one_step_in_doubt([adopted(EVIDENCE, way), adopted(EVIDENCE, other)], [finding, finding])
    assert (first.confidence, second.confidence) == (confidence, "likely")
    assert first.effect == "a"
