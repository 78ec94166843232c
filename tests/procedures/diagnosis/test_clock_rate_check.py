from dataclasses import replace

import numpy as np
import pytest

from procedures.anomalies.clock_rate_check import find_clock, with_true_clock
from procedures.calibration.joint_calibration import report, solve
from procedures.campaign.campaign import clock_rate
from procedures.diagnosis.diagnose import diagnose
from procedures.uncertainty import sources
from procedures.uncertainty.budget import budget, with_clock
from procedures.uncertainty.sources import GivenValues
from tests.procedures.diagnosis.planted import planted, with_reference_time

BASE = planted(1, dwell_s=10.0)


@pytest.mark.parametrize(("jitter", "step"), [(1e-3, 0.0), (1e-2, 1e-2), (0.0, 1.0)])
def test_the_rate_is_found_within_its_own_sigma(jitter: float, step: float) -> None:
    errors = []
    for seed in range(20):
        rate = clock_rate(with_reference_time(BASE, 37.0, seed, jitter, step))
        assert rate is not None
        errors.append((rate.ppm - 37.0) / rate.std)
    assert np.max(np.abs(errors)) < 4.5
    assert np.std(errors) < 1.5


def test_a_right_clock_is_not_called_wrong() -> None:
    wrong = sum(bool(find_clock([with_reference_time(BASE, 0.0, seed)])[0]) for seed in range(40))
    assert wrong <= 1


def test_what_is_not_known_of_a_clock_put_right_is_in_the_uncertainty_of_k() -> None:
    plain = planted(2, {"clock.rate": {"value": 500.0}}, turns=True)
    campaign = with_reference_time(plain, 500.0, 2, jitter=0.3)
    found = diagnose([campaign])
    (clock,) = [each for each in found.findings if each.effect == "clock.rate"]
    assert found.clock == pytest.approx(1e-6 * clock.std[0])
    assert found.clock > 2e-5
    k = found.solution.accelerometer
    assert k is not None
    assert np.all(k.scale_factor.std >= found.clock * k.scale_factor.value)
    rows = [found.solution.names.index(f"accelerometer.scale_factor.{axis}") for axis in "xyz"]
    assert np.sqrt(np.diag(found.solution.covariance)[rows]) == pytest.approx(k.scale_factor.std)
    for solution, fits in ((found.solution, found.after), (found.solution_before, found.before)):
        wide, narrow = solution.accelerometer, report(fits).accelerometer
        assert wide is not None
        assert narrow is not None
        added = np.sqrt(wide.scale_factor.std**2 - narrow.scale_factor.std**2)
        assert added == pytest.approx(found.clock * wide.scale_factor.value, rel=1e-6)
    clock_part = {
        one.name: part.std
        for one in budget(found.after, GivenValues(clock=found.clock))
        for part in one.contributions
        if part.source == sources.CLOCK
    }
    assert clock_part["accelerometer.scale_factor.x"] == pytest.approx(found.clock * k.scale_factor.value[0])
    wider = with_clock(found.solution, found.after, found.clock)
    for triad in ("accelerometer", "gyroscope"):
        before, after = getattr(found.solution, triad), getattr(wider, triad)
        for name, part in (("scale_factor", "scale_factor"), ("bias", "bias")):
            std = np.sqrt(getattr(after, part).std ** 2 - getattr(before, part).std ** 2)
            expected = [clock_part.get(f"{triad}.{name}.{axis}", 0.0) for axis in "xyz"]
            assert std == pytest.approx(expected, rel=1e-3, abs=1e-9)


def test_positive_is_fast_and_the_correction_gives_the_scale_factor_back() -> None:
    ppm = 500.0
    campaign = planted(2, {"clock.rate": {"value": ppm}})
    (found,), (test,) = find_clock([with_reference_time(campaign, ppm, 2)])
    assert found.confidence == "established"
    assert test.log_odds > 0
    assert abs(found.value[0] - ppm) < 4 * found.std[0]
    got = solve(with_true_clock([campaign], float(found.value[0]))).accelerometer
    expected = solve([planted(2)]).accelerometer
    assert got is not None
    assert expected is not None
    off = got.scale_factor.value - expected.scale_factor.value
    assert np.all(np.abs(off) < 4 * np.hypot(got.scale_factor.std, 1e-6 * found.std * got.scale_factor.value))


def test_a_period_that_is_not_the_stated_one_names_both_explanations() -> None:
    (found,), _ = find_clock([replace(BASE, nominal_period=0.0198)])
    assert found.confidence == "possible"
    assert found.aliases == ("imu.sample_period_s",)
    assert found.value[0] == pytest.approx(1e6 * (0.02 / 0.0198 - 1))
    assert find_clock([replace(BASE, nominal_period=0.020001)]) == ((), ())
