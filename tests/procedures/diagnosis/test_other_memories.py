"""A name must survive another memory of what was before: a lag of a lag, a play, a hinge that forgets nothing."""

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from procedures.effects.temperature_history import played
from tests.procedures.diagnosis.test_polynomial_orders import T, campaign, following
from tests.procedures.effects.test_every_effect import UNIT, baseline


def sure(found: Diagnosis) -> set[str]:
    return {each.effect for each in found.findings if each.kind == "instrument" and each.confidence != "ambiguous"}


def twice(first: float, second: float) -> np.ndarray:
    """Return what lags behind what lags (n,), in steps of a second."""
    once = following(first)
    found = once.copy()
    for i in range(1, len(T)):
        found[i] = found[i - 1] + (once[i] - found[i - 1]) / second
    return found


@pytest.mark.parametrize("tau", [900.0, 1500.0])
def test_a_lag_of_a_lag_is_no_lag_for_sure(tau: float) -> None:
    found = diagnose([campaign(11, 2e-5 * (twice(tau, tau) - 25))])
    assert "accelerometer.temperature_lag" not in sure(found)
    assert found.verdict in {"partly", "unexplained", "ambiguous"}


def test_a_lag_is_still_one() -> None:
    found = diagnose([campaign(12, 2e-5 * (following(900.0) - 25))])
    assert sure(found) == {"accelerometer.temperature_lag"}


def test_a_play_follows_from_where_it_began() -> None:
    seen = baseline().evidence.excitation
    T_seen = seen.temperature[np.argsort(seen.t, kind="stable")]
    for width in (0.5, 2.0):
        left = played(seen, width)
        assert np.max(np.abs(seen.temperature - left)) <= width + 1e-12
        begin = max(UNIT.temperature_start_c, T_seen[0] - width)  # where it was when the unit was switched on
        assert left.min() == pytest.approx(begin, abs=0.01)
        assert left.max() == pytest.approx(max(T_seen.max() - width, begin), abs=0.01)
