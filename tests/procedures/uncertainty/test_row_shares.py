"""Every whitened row has a variance of one: who makes it up, dwell by dwell, turn by turn and prior by prior."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.campaign.campaign import ProcedureSigma
from procedures.uncertainty import sources
from procedures.uncertainty.row_variance import gyroscope_shares, joint_shares
from procedures.uncertainty.sources import Shares
from tests.procedures.diagnosis.planted import planted


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
