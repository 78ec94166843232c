"""A term tried by sums over classes is tested as by its fit: the same coefficients, sigmas, degrees of freedom."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.diagnosis.linear_model import Term, fit_linear, significance
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.term_trial import tried_term
from tests.procedures.diagnosis.redrawn import seen_by

NAMES = ("accelerometer.quadratic", "gyroscope.g_sensitivity", "accelerometer.bias_drift", "gyroscope.magnetic")


def livelier(evidence: Evidence, seed: int, times: float) -> Evidence:
    """Return an evidence whose means and slopes scatter by more than their noise."""
    drawn = np.random.default_rng(seed).standard_normal(len(evidence.residual)) * evidence.sigma
    return replace(evidence, residual=drawn * np.where(evidence.rows("mean", "slope"), times, 1.0))


@pytest.mark.parametrize("times", [1.0, 1.5, 4.0, 300.0, 3e4])
@pytest.mark.parametrize(
    "beside", [(), ("accelerometer.quadratic",), ("accelerometer.quadratic", "gyroscope.magnetic")]
)
def test_a_trial_says_what_the_whole_fit_says(times: float, beside: tuple[str, ...]) -> None:
    _, before, pool = seen_by("certified")
    evidence, others = livelier(before, 3, times), tuple(pool[name][0].term for name in beside)
    widened = 0
    for name in set(NAMES) - set(beside):
        term = pool[name][0].term
        fit = fit_linear(evidence, [*others, term])
        widened += int(np.any(fit.factor > 1))
        told, got = significance(evidence, fit), tried_term(evidence, others, term)
        assert got is not None
        np.testing.assert_allclose((got.value - told.value) / told.std, 0, atol=1e-7)
        np.testing.assert_allclose(got.std, told.std, rtol=1e-7)
        assert (got.log_p, got.statistic, got.dof) == pytest.approx(
            (told.log_p, told.statistic, told.dof), rel=1e-6
        )
    assert (widened > 0) == (times > 1)


def test_what_the_model_leaves_too_little_of_is_not_tried() -> None:
    _, evidence, pool = seen_by("certified")
    term = pool["accelerometer.quadratic"][0].term
    std = np.sqrt(np.diag(fit_linear(evidence, [term], factor=np.ones(len(evidence.residual))).coefficients()[1]))
    assert tried_term(evidence, (), term) is not None
    assert tried_term(evidence, (), Term(term.H * 1e-9, term.plausible)) is None
    assert np.all(std < 0.5 * term.plausible)
