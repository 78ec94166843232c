"""A clock's rate from stamps that were read late, latched by a pulse, cut to seconds, or stepped in between."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.reference_time import fit_clock
from procedures.statistics.line_with_correlated_errors import fit_correlated_line
from tests.procedures.counts.recorded_delays import LAYOUTS, campaign, read_traces

TRACES = read_traces()
DWELLS, DWELL_S, PAUSE_S = 12, 30.0, 10.0


def stamped(ppm: float, late: Callable[[FloatArray], FloatArray]) -> list[tuple[FloatArray, FloatArray]]:
    """Return device time and reference time [s] of dwells, the reference ``late`` (n,) [s] at true times."""
    begin = (DWELL_S + PAUSE_S) * np.arange(DWELLS)
    true = [each + np.arange(0.0, DWELL_S, 0.06) for each in begin]
    return [((1 + 1e-6 * ppm) * each, 1.7e9 + each + late(each)) for each in true]


@pytest.mark.parametrize("loads", [(0,), (1, 2), (4, 8), (15,)])
def test_on_a_busy_machine_no_rate_is_invented_and_a_true_one_is_found(loads: tuple[int, ...]) -> None:
    traces = [trace for trace in TRACES if trace.load in loads]
    z = list[float]()
    for i in range(8):
        ppm = (0.0, 50.0, -50.0, 0.0)[i % 4]
        rate = fit_clock(campaign(traces, *LAYOUTS[i % 2], ppm, np.random.default_rng([3, i])))
        assert rate is not None
        z.append((rate.ppm - ppm) / rate.std)
        if ppm and max(loads) <= 2:
            assert abs(rate.ppm) > 4 * rate.std
    assert np.max(np.abs(z)) < 4
    assert 0.3 < np.sqrt(np.mean(np.square(z))) < 2.0  # of eight


def test_the_traces_hold_loads_from_none_to_fifteen_and_readers_that_were_killed() -> None:
    assert len(TRACES) == 20
    assert {trace.load for trace in TRACES} == {0, 1, 2, 4, 8, 15}
    assert sum(trace.is_killed for trace in TRACES) == 3
    assert all(trace.row.min() > 0 for trace in TRACES)
    assert all(trace.mark.min() > 0 for trace in TRACES)


@pytest.mark.parametrize("memory", [0.0, 0.3, 0.6, 0.8])
def test_errors_that_hang_together_are_in_the_sigma(memory: float) -> None:
    rng, x, z = np.random.default_rng(1), np.arange(24.0), list[float]()
    for _ in range(300):
        noise = rng.standard_normal(24)
        for i in range(1, 24):
            noise[i] = memory * noise[i - 1] + np.sqrt(1 - memory**2) * noise[i]
        line = fit_correlated_line(x, noise, np.zeros(24, dtype=np.int64))
        assert line is not None
        z.append(line.slope / line.std)
    assert 0.55 < np.std(z) < 1.5


@pytest.mark.parametrize("seed", range(5))
def test_a_pulse_that_errs_to_both_sides_is_used_to_its_full_worth(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate = fit_clock(stamped(37.0, lambda true: 1e-3 * rng.standard_normal(len(true))))
    assert rate is not None
    assert abs(rate.ppm - 37.0) < 4 * rate.std
    assert rate.std < 0.3  # 1 ms over the root of 6000 rows, 140 s: 0.1 ppm


@pytest.mark.parametrize("ppm", [0.0, 37.0, -50.0, 1000.0])
def test_whole_seconds_tell_no_more_than_the_moment_they_go_on(ppm: float) -> None:
    rate = fit_clock(stamped(ppm, lambda true: np.floor(true) - true))
    assert rate is not None
    assert abs(rate.ppm - ppm) < 4 * rate.std
    assert rate.std > 0.06 / np.sqrt(6) / 480 * 1e6 * 0.9


@pytest.mark.parametrize("leap", [1.0, -1.0, 5000.0])
def test_a_reference_that_is_set_between_two_dwells_does_not_bend_the_rate(leap: float) -> None:
    rng = np.random.default_rng(2)
    rate = fit_clock(stamped(20.0, lambda true: 1e-3 * rng.exponential(size=len(true)) + leap * (true > 375)))
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std < 10


@pytest.mark.parametrize("step", [2e-3, 0.3, 1.5, -0.02])
@pytest.mark.parametrize("at_s", [235.0, 250.0])  # between two dwells, inside one
def test_a_delay_that_changes_once_is_no_rate(step: float, at_s: float) -> None:
    for seed, ppm in enumerate((0.0, 50.0, -50.0)):
        rng = np.random.default_rng(seed)
        rate = fit_clock(stamped(ppm, lambda true: 1e-3 * rng.exponential(size=len(true)) + step * (true > at_s)))  # noqa: B023
        assert rate is not None
        assert abs(rate.ppm - ppm) < 4 * rate.std < 5


def test_delays_that_change_three_times_are_in_the_sigma() -> None:
    rng = np.random.default_rng(5)
    rate = fit_clock(
        stamped(
            50.0,
            lambda true: (
                1e-3 * rng.exponential(size=len(true)) + 0.02 * ((true > 115) + 3.0 * (true > 235) - (true > 355))
            ),
        )
    )
    assert rate is not None
    assert abs(rate.ppm - 50.0) < 4 * rate.std


@cache
def rates_behind_delays(is_walk: bool, dwells: int, dwell_s: float) -> list[tuple[float, float]]:
    """Return rates and their sigmas [ppm] of clocks 20 ppm fast, each record with a delay of its own."""
    found = list[tuple[float, float]]()
    for seed in range(30):
        rng = np.random.default_rng(seed)
        delay = 0.03 * rng.standard_normal(dwells)
        pieces = list[tuple[FloatArray, FloatArray]]()
        for i, late in enumerate(np.cumsum(delay) if is_walk else delay):
            true = (dwell_s + 12.0) * i + np.arange(0.0, dwell_s, 0.25)
            pieces.append((true * (1 + 20e-6), 1.7e9 + true + late + 1e-3 * rng.exponential(size=len(true))))
        rate = fit_clock(pieces)
        assert rate is not None
        found.append((rate.ppm, rate.std))
    return found


@pytest.mark.parametrize("is_walk", [True, False])
@pytest.mark.parametrize(("dwells", "dwell_s", "least_ppm"), [(7, 8.0, 20.0), (12, 30.0, 2.0), (24, 10.0, 8.0)])
def test_delays_of_each_records_own_leave_the_rate_to_what_is_within_records(
    is_walk: bool, dwells: int, dwell_s: float, least_ppm: float
) -> None:
    ppm, std = np.array(rates_behind_delays(is_walk, dwells, dwell_s)).T
    errors = ppm - 20.0
    z = errors / std
    assert np.max(np.abs(z)) < 4
    assert np.sqrt(np.mean(np.square(z))) < 1.5
    assert np.sqrt(np.mean(np.square(errors))) < least_ppm  # steps of 30 ms are 200 ppm and more of a rate


@pytest.mark.parametrize("begin_s", [80.0, 200.0, 300.0])
def test_a_delay_that_grows_through_two_records_is_no_rate(begin_s: float) -> None:
    def late(true: FloatArray) -> FloatArray:
        return 1e-5 * np.floor(1e3 * true % 7.0) + 1e-3 * np.clip(true - begin_s, 0.0, 60.0)

    rate = fit_clock(stamped(20.0, late))
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std


def test_a_step_that_a_few_noisy_points_cannot_tell_from_a_rate_widens_the_sigma() -> None:
    x, z = np.arange(8.0), list[float]()
    for seed in range(100):
        noise = np.random.default_rng(seed).standard_normal(8)
        line = fit_correlated_line(x, noise + 5.0 * (x > 3.5), np.zeros(8, dtype=np.int64))
        assert line is not None
        z.append(line.slope / line.std)
    assert np.max(np.abs(z)) < 4
    assert np.sqrt(np.mean(np.square(z))) < 1.7


def test_a_device_that_was_switched_off_in_between_has_one_rate_still() -> None:
    rng = np.random.default_rng(3)
    pieces = stamped(20.0, lambda true: 1e-3 * rng.exponential(size=len(true)))
    anew = [(t - t[0] if i == 6 else t - pieces[6][0][0], u) for i, (t, u) in enumerate(pieces) if i >= 6]
    rate = fit_clock([*pieces[:6], *anew])
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std < 20


@pytest.mark.parametrize("dwells", [96, 97])
def test_many_records_have_one_rate_whether_what_is_within_them_is_looked_at_or_not(dwells: int) -> None:
    rng, pieces = np.random.default_rng(6), list[tuple[FloatArray, FloatArray]]()
    for i in range(dwells):
        true = 20.0 * i + np.arange(0.0, 10.0, 0.25)
        pieces.append((true * (1 + 20e-6), 1.7e9 + true + 1e-3 * rng.exponential(size=len(true))))
    rate = fit_clock(pieces)
    assert rate is not None
    assert abs(rate.ppm - 20.0) < 4 * rate.std < 0.1


def test_too_few_rows_tell_nothing() -> None:
    t = np.arange(8.0)
    assert fit_clock([]) is None
    assert fit_clock([(t, t)]) is None
    assert fit_clock([(t, np.full(8, np.nan))]) is None
