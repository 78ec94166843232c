"""A name must survive another memory of what was before: a lag of a lag, a play, a hinge that forgets nothing."""

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from tests.procedures.diagnosis.test_polynomial_orders import T, campaign, following


def sure(found: Diagnosis) -> set[str]:
    return {each.effect for each in found.findings if each.kind == "instrument" and each.confidence != "ambiguous"}


def twice(first: float, second: float) -> np.ndarray:
    """Return what lags behind what lags (n,), in steps of a second."""
    once = following(first)
    found = once.copy()
    for i in range(1, len(T)):
        found[i] = found[i - 1] + (once[i] - found[i - 1]) / second
    return found


@pytest.mark.parametrize("tau", [900.0])
def test_a_lag_of_a_lag_is_no_lag_for_sure(tau: float) -> None:
    found = diagnose([campaign(11, 2e-5 * (twice(tau, tau) - 25))])
    assert "accelerometer.temperature_lag" not in sure(found)
    assert found.verdict in {"partly", "unexplained", "ambiguous"}


def test_a_lag_is_still_one() -> None:
    found = diagnose([campaign(12, 2e-5 * (following(900.0) - 25))])
    assert sure(found) == {"accelerometer.temperature_lag"}
