"""UTC over the station's clock, from marks that were read late."""

import numpy as np
import pytest

from procedures.statistics.line_fits import fit_earliest_line

NS = 10**9


@pytest.mark.parametrize("seed", range(2))
def test_the_line_follows_the_least_late_marks_when_a_load_begins(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = np.arange(0.0, 40.0, 0.2)
    late = 1e-3 + rng.exponential(np.where(true > 20, 0.02, 1e-3))
    line = fit_earliest_line(
        np.round((100 + true + late) * NS).astype(np.int64), np.round(true * NS).astype(np.int64)
    )
    assert line is not None
    off = np.array([line.at(round((100 + at) * NS)) - at for at in true])
    assert -3e-3 < off.min()
    assert off.max() < 3e-3


@pytest.mark.parametrize("ahead", [30.0, 1.0, -30.0])
def test_a_reference_that_was_set_wrong_for_a_while_does_not_lift_it(ahead: float) -> None:
    true = np.arange(0.0, 40.0, 0.2)
    wrong = ahead * ((true > 10) & (true < 15))
    line = fit_earliest_line(
        np.round((true + 1e-3) * NS).astype(np.int64), np.round((true + wrong) * NS).astype(np.int64)
    )
    assert line is not None
    assert line.rate == pytest.approx(1.0, abs=1e-6)
    assert line.at(20 * NS) == pytest.approx(20.0, abs=2e-3)
