"""Parts of variances by hand: white noise and its degrees of freedom, scatter, what the global test leaves."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.dwells_and_turns.latitude_and_time_base import clock_on_accelerometer, clock_on_moves
from procedures.uncertainty import sources
from procedures.uncertainty.excess_scatter import unexplained
from procedures.uncertainty.noise_and_quantisation import durations_s, noise_dof, white_variance
from procedures.uncertainty.row_variance import scatter_dof
from procedures.uncertainty.temperature import TemperatureEffect


def counts(n: int, period: float) -> CountSeries:
    return CountSeries(np.arange(n) * period, np.zeros((n, 3), np.int64), None, np.full(n, np.nan), period)


def rates(n: int) -> RateSeries:
    return RateSeries(np.arange(n) * 0.01, np.zeros((n, 3)), None, np.full(n, np.nan), 0.01)


def test_white_noise_is_a_density_over_the_time_and_never_all_there_is() -> None:
    variance = np.array([[1.0, 2.0, 0.01], [1.0, 0.1, 5.0]])
    white = white_variance(np.array([1.0, 2.0, 3.0]), np.array([4.0, 9.0]), variance)
    np.testing.assert_allclose(white, [[1 / 4, 1.0, 0.01], [1 / 9, 0.1, 1.0]])
    assert durations_s([counts(500, 0.02), rates(40)]).tolist() == [10.0, 0.4]


def test_looks_at_noise_in_counts_are_as_many_as_remainders_allow() -> None:
    """0.3 counts per sqrt(sample): one look in 0.3^(-2/3) samples, every other independent; above 1 every one."""
    noise = np.array([3.0, 0.3, 20.0])  # counts/sqrt(s), 100 samples a second
    found = noise_dof([counts(1000, 0.01), counts(600, 0.01)], noise)
    assert found == pytest.approx([800 * 0.3 ** (2 / 3) - 1, 800 * 0.03 ** (2 / 3) - 1, 800 - 1])
    assert noise_dof([counts(1000, 0.01)], np.zeros(3)) == pytest.approx([1.0, 1.0, 1.0])


def test_looks_at_noise_in_rates_are_two_thirds_of_the_blocks() -> None:
    noise = np.ones(3)
    assert noise_dof([rates(1000), rates(100)], noise) == pytest.approx([2 / 3 * 228 - 1] * 3)
    assert noise_dof([], noise).tolist() == [1.0] * 3


def test_a_scatter_found_beside_what_was_expected_is_known_by_its_share_squared() -> None:
    assert scatter_dof(40.0, np.array([3.0, 1.0]), np.array([1.0, 1.0])) == pytest.approx(40 * 0.375**2)
    assert scatter_dof(40.0, np.array([1.0]), np.array([0.1])) == 1.0


OBSERVED = np.array([True, True, False])


def test_squares_beyond_the_global_test_widen_every_observation_by_one_factor() -> None:
    """Chi-square of 10: the upper hundredth is 23.21."""
    assert unexplained("gyroscope", 23.1, 10, OBSERVED, None) == {}
    ((cell, share),) = unexplained("gyroscope", 23.3, 10, OBSERVED, None).items()
    assert share == pytest.approx([1.33, 1.33, 0.0])
    assert (cell.source, cell.of) == (sources.UNEXPLAINED, "gyroscope")
    assert cell.dof == pytest.approx(10 * (1 - 1 / 2.33) ** 2)
    ((cell, share),) = unexplained("gyroscope", 12.0, 10, OBSERVED, None, is_left=True).items()
    assert share == pytest.approx([0.2, 0.2, 0.0])
    assert cell.dof == 1.0
    for chi2, dof in ((10.0, 10), (9.0, 10), (5.0, 0), (5.0, -1)):
        assert unexplained("gyroscope", chi2, dof, OBSERVED, None, is_left=True) == {}


def test_what_temperature_explains_is_not_counted_again() -> None:
    effect = TemperatureEffect(np.zeros((3, 6)), np.zeros(6), np.zeros((6, 6)), chi2=20.0, rank=2)
    assert unexplained("gyroscope", 23.3 + 20.0, 12, OBSERVED, effect).keys()
    assert unexplained("gyroscope", 23.1 + 20.0, 12, OBSERVED, effect) == {}
    assert unexplained("gyroscope", 43.3, 11, OBSERVED, replace(effect, rank=1)).keys()


@pytest.mark.parametrize("is_counts", [True, False])
def test_a_wrong_second_scales_what_counts_and_leaves_what_is_a_rate(is_counts: bool) -> None:
    value = np.arange(1.0, 16.0)
    of_accelerometer, of_moves = np.zeros(15), np.zeros(15)
    of_accelerometer[:3] = value[:3] * is_counts
    of_moves[12:], of_moves[:3] = value[12:], value[:3] * (not is_counts)
    assert clock_on_accelerometer(value, is_counts).tolist() == of_accelerometer.tolist()
    assert clock_on_moves(value, is_counts).tolist() == of_moves.tolist()
