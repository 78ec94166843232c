from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration import solve
from procedures.campaign import Campaign
from procedures.diagnosis.clock import clock_rate, find_clock, with_true_clock
from procedures.diagnosis.tail import log_f_sf
from procedures.effects import EFFECTS
from tests.procedures.diagnosis.planted import planted, with_reference_time

BASE = planted(1, dwell_s=10.0)


@pytest.mark.parametrize(("jitter", "step"), [(1e-3, 0.0), (1e-2, 1e-2), (0.0, 1.0)])
def test_the_rate_is_found_within_its_own_sigma(jitter: float, step: float) -> None:
    errors = []
    for seed in range(100):
        rate = clock_rate(with_reference_time(BASE, 37.0, seed, jitter, step))
        assert rate is not None
        errors.append((rate.ppm - 37.0) / rate.std)
    assert np.max(np.abs(errors)) < 4.5
    assert np.std(errors) < 1.25


def test_a_right_clock_is_not_called_wrong() -> None:
    wrong = sum(bool(find_clock([with_reference_time(BASE, 0.0, seed)])[0]) for seed in range(200))
    assert wrong <= 2


def test_a_step_of_the_reference_does_not_bend_the_rate() -> None:
    campaign = with_reference_time(BASE, 37.0, 0)
    last = campaign.dwells[-1]
    stepped = replace(last.series, extra={"utc_s": last.series.extra["utc_s"] + 1.0})  # a leap second
    rate = clock_rate(replace(campaign, dwells=(*campaign.dwells[:-1], replace(last, series=stepped))))
    assert rate is not None
    assert abs(rate.ppm - 37.0) < 4 * rate.std < 10


def test_positive_is_fast_and_the_correction_gives_the_scale_factor_back() -> None:
    ppm = 500.0
    campaign = planted(2, {"clock.rate": {"value": ppm}})
    (found,), (test,) = find_clock([with_reference_time(campaign, ppm, 2)])
    assert found.confidence == "established"
    assert test.log_p_adjusted < np.log(0.01)
    assert abs(found.value[0] - ppm) < 4 * found.std[0]
    got = solve(with_true_clock([campaign], float(found.value[0]))).accelerometer
    expected = solve([planted(2)]).accelerometer
    assert got is not None
    assert expected is not None
    off = got.scale_factor.value - expected.scale_factor.value
    assert np.all(np.abs(off) < 4 * np.hypot(got.scale_factor.std, 1e-6 * found.std * got.scale_factor.value))


def test_a_period_that_is_not_the_stated_one_names_both_explanations() -> None:
    (found,), _ = find_clock([replace(BASE, nominal_period=0.0198)])
    assert found.confidence == "ambiguous"
    assert found.aliases == ("imu.sample_period_s",)
    assert found.value[0] == pytest.approx(1e6 * (0.02 / 0.0198 - 1))
    assert find_clock([replace(BASE, nominal_period=0.020001)]) == ((), ())


def test_periods_that_scatter_as_much_as_they_are_off_say_nothing_of_the_clock() -> None:
    def with_periods(std: float) -> Campaign:
        off = 3e-3 + std * np.resize([-1.0, 1.0], len(BASE.dwells))
        dwells = [
            replace(d, series=replace(d.series, period=0.02 * (1 + e)))
            for d, e in zip(BASE.dwells, off, strict=True)
        ]
        return replace(BASE, dwells=tuple(dwells), turns=(), rests=(), sequences=(), nominal_period=0.02)

    assert find_clock([with_periods(2.5e-3)]) == ((), ())
    (found,), _ = find_clock([with_periods(3e-4)])
    n, f = len(BASE.dwells), float((found.value[0] / found.std[0]) ** 2)
    assert found.log_p == pytest.approx(log_f_sf(f, 1, n - 1) + np.log(len(EFFECTS)))
