"""The decision rule against counting: a true value beyond its limit is as rare as the risk says."""

import math

import numpy as np
import pytest

from fixtures_db.model_limits import Limit
from station.results.certificate.conformity import LimitComparison, conformity, greatest_risk, printed
from station.results.certificate.printed_results import MeasuredParameter

LIMIT = Limit("gyroscope.bias.x", -1.0, 1.0, "deg/h", 1.64)


@pytest.mark.parametrize("dof", [4.0, math.inf])
@pytest.mark.parametrize("value", [-0.9, 0.0, 0.7, 1.2])
def test_the_risk_is_the_share_of_true_values_beyond_the_limits(dof: float, value: float) -> None:
    rng, n, std = np.random.default_rng(1), 200_000, 0.3
    spread = rng.standard_normal(n) if math.isinf(dof) else rng.standard_t(dof, n)
    share = float(np.mean(np.abs(value + std * spread) > 1.0))
    risk = LimitComparison(LIMIT, value, std, dof, "PASS").risk
    assert risk is not None
    assert abs(risk - share) < 4 * math.sqrt(max(risk * (1 - risk), 1e-6) / n)


@pytest.mark.parametrize(("guard", "percent"), [(0.0, 50.0), (1.64, 5.05), (2.0, 2.28)])
def test_the_greatest_risk_is_the_normal_tail(guard: float, percent: float) -> None:
    assert abs(100 * greatest_risk(guard) - percent) < 0.01
    assert greatest_risk(guard, 5.0) >= greatest_risk(guard)


@pytest.mark.parametrize(("value", "word"), [(0.83, "PASS"), (0.84, "FAIL"), (-0.84, "FAIL"), (1.1, "FAIL")])
def test_a_value_is_accepted_within_the_tolerance_less_the_guard_band(value: float, word: str) -> None:
    document = {
        "limits": [{"parameter": LIMIT.parameter, "low": -1.0, "high": 1.0, "unit": "deg/h", "guard_band": 1.64}],
        "verdict": "PASS",
    }
    result = MeasuredParameter(LIMIT.parameter, value, "deg/h", 0.1, math.inf, 1.96, 0.196, ())
    found = conformity(document, {LIMIT.parameter: result})  # w = 1.64 * 0.1, by the combined u, not the solve's
    assert found is not None
    assert (found.word, found.stored) == (word, "PASS")
    [(*_, guard, bar, _, _)] = printed(found.against)
    assert guard.strip() == "0.16"
    assert bar == (pytest.approx(value), pytest.approx(0.164))


def test_what_was_judged_then_is_judged_now_and_what_has_no_value_is_not_measured() -> None:
    limits = [
        {"parameter": "residual.p_value", "low": 0.01, "unit": "1", "guard_band": 0.0},
        {"parameter": "slab.tilt.east", "low": -1e-4, "high": 1e-4, "unit": "rad", "guard_band": 2.0},
    ]
    judged = [{"parameter": "residual.p_value", "verdict": "PASS", "value": 0.2, "unit": "1"}]
    found = conformity({"limits": limits, "judged": judged}, {})
    assert found is not None
    assert [one.word for one in found.against] == ["PASS", "NOT_MEASURED"]
    assert found.word == "NOT_MEASURED"
    assert conformity({}, {}) is None
