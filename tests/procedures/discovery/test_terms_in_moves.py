import numpy as np

from procedures.diagnosis.residual_rows import evidence_of
from procedures.discovery.library import Rows, library
from procedures.effects.effect import Columns, per_axis
from tests.procedures.diagnosis.test_move_rows import seen


def test_a_term_of_the_library_turns_moves_as_an_effects_columns_do() -> None:
    _, fits, _ = seen()
    evidence = evidence_of(fits)
    term = next(
        each
        for each in library(evidence.excitation, ["gyroscope"])
        if each.texts == ("f",) or each.texts == ("u",)
    )
    value = evidence.excitation.f if term.texts == ("f",) else evidence.excitation.omega
    H = evidence.column(Columns(("x", "y", "z"), gyro=per_axis(value))) / evidence.sigma[:, None]
    np.testing.assert_allclose(Rows(evidence).of([term])[:, 0], H, rtol=1e-9, atol=1e-9)
    assert np.abs(H[evidence.rows("move")]).max() > 0
