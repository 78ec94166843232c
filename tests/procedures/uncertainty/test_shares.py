"""Parts of variances by hand: white noise and its degrees of freedom, scatter, what the global test leaves."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.campaign.campaign import ProcedureSigma
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.twelve_positions.gyroscope_fit import clock_on_accelerometer, clock_on_moves
from procedures.uncertainty import sources
from procedures.uncertainty.excess_scatter import TemperatureEffect, unexplained
from procedures.uncertainty.row_variance import (
    durations_s,
    gyroscope_shares,
    joint_shares,
    noise_dof,
    scatter_dof,
    white_variance,
)
from procedures.uncertainty.sources import Shares
from tests.procedures.diagnosis.planted import planted


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


def test_a_scatter_found_with_what_was_expected_is_known_by_its_share_squared() -> None:
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


# Every whitened row has a variance of one: its parts by source


@pytest.fixture(scope="module")
def fits() -> CampaignFits:
    sigma = ProcedureSigma(unsettled_gyro=2e-7, unsettled_accelerometer=3e-5)
    return fit([replace(planted(2, dwell_s=10.0, turns=True), sigma=sigma)])


def of_source(shares: Shares, source: str) -> np.ndarray:
    found: np.ndarray = np.sum([part for cell, part in shares.items() if cell.source == source], axis=0)
    return found


@pytest.mark.parametrize("tilts", [True, False])
def test_the_parts_of_every_row_are_all_of_it(fits: CampaignFits, tilts: bool) -> None:
    gyroscope = fits.gyroscope
    assert fits.accelerometer is not None
    assert gyroscope is not None
    np.testing.assert_allclose(sum(joint_shares(fits.accelerometer, "accelerometer").values()), 1.0, rtol=1e-9)
    whole = np.ones(len(gyroscope.joint.fit.residual))
    first = 3 * (12 + len(gyroscope.turns))
    whole[first : first + gyroscope.joint.bench.shared * tilts] = 0.0
    np.testing.assert_allclose(sum(gyroscope_shares(gyroscope, tilts).values()), whole, rtol=1e-9, atol=1e-12)


def test_the_priors_of_the_bench_are_named_by_what_they_are_of(fits: CampaignFits) -> None:
    """One campaign on a cube: slab 2, gravity 1, six faces with two tilts each, a heading a position."""
    assert fits.accelerometer is not None
    shares = joint_shares(fits.accelerometer, "accelerometer")
    rows = {source: of_source(shares, source)[36:].sum() for source in {cell.source for cell in shares}}
    expected = {sources.SLAB: 2.0, sources.GRAVITY: 1.0, sources.CUBE: 12.0, sources.HEADING: 12.0}
    assert {name: rows[name] for name in expected} == pytest.approx(expected)
    assert len(fits.accelerometer.fit.residual) == 36 + 27
    assert not any(rows[name] for name in (sources.COUNTING, sources.QUANTISATION, sources.WARM_UP))


def test_a_dwells_row_is_noise_and_remainders_of_counts_and_what_was_stated_of_the_warm_up(
    fits: CampaignFits,
) -> None:
    joint = fits.accelerometer
    assert joint is not None
    shares = joint_shares(joint, "accelerometer")
    for row, (i, axis) in enumerate(np.ndindex(12, 3)):
        estimate = joint.seen.estimates[i][axis]
        white = min(estimate.noise**2 / 10.0, estimate.std**2)
        parts = {
            sources.COUNTING: white, sources.QUANTISATION: estimate.std**2 - white,
            sources.WARM_UP: (3e-5 / 9.80665 * joint.k[axis]) ** 2,
        }  # fmt: skip
        for source, part in parts.items():
            assert of_source(shares, source)[row] * joint.sigma[i, axis] ** 2 == pytest.approx(part, rel=1e-3)


def test_a_turns_row_is_noise_over_its_time_remainders_scatter_and_drift(fits: CampaignFits) -> None:
    gyroscope = fits.gyroscope
    assert gyroscope is not None
    joint, shares = gyroscope.joint, gyroscope_shares(gyroscope, tilts=True)
    for i, turn in enumerate(gyroscope.turns):
        seconds = len(turn.record.series) * turn.record.series.period
        rows = slice(36 + 3 * i, 39 + 3 * i)
        variance = gyroscope.turn_sigma[i] ** 2
        white = np.minimum(joint.seen.noise**2 * seconds, turn.std**2)
        scatter = (joint.excess * seconds) ** 2
        parts = {
            sources.COUNTING: white, sources.QUANTISATION: turn.std**2 - white, sources.INSTABILITY: scatter,
            sources.WARM_UP: variance - turn.std**2 - scatter,
        }  # fmt: skip
        for source, part in parts.items():
            np.testing.assert_allclose(of_source(shares, source)[rows] * variance, part, rtol=1e-9, atol=1e-15)
        drift = np.degrees(2e-7) * seconds * joint.k  # of the bias, as stated
        np.testing.assert_allclose(np.sqrt(parts[sources.WARM_UP]), drift, rtol=1e-3)
        axis = [f"gyroscope {letter}" for letter in "xyz"]
        for k in range(3):
            (alone,) = [s for c, s in shares.items() if c.source == sources.COUNTING and c.of == axis[k]]
            assert np.flatnonzero(alone[rows]).tolist() in ([k], [])
