"""The budget against Monte Carlo (JCGM 101): of the observations, and in small of the whole chain."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.triad_calibration import triad_vector
from procedures.units import DEG_H_PER_DEG_S
from tests.benchmarks.budget import compare, trial
from tests.procedures.linear_chain import accelerometer_residual, drawn, gyroscope_residual
from tests.procedures.test_uncertainty import fitted, simulated

DRAWS = 250
OWN = 1 / np.sqrt(2 * DRAWS)  # a standard deviation of so many draws is known to 4.5 %

SHOWN = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14]  # E off its diagonal


@pytest.mark.proof
@pytest.mark.parametrize("certificate", [None, 5e-6])
@pytest.mark.parametrize("triad", ["accelerometer", "gyroscope"])
def test_the_fit_s_covariance_is_the_scatter_of_its_rows_redrawn(triad: str, certificate: float | None) -> None:
    fits = fitted(simulated(1, certificate))
    assert fits.accelerometer is not None
    assert fits.gyroscope is not None
    rng = np.random.default_rng(5)
    if triad == "accelerometer":
        values = drawn(fits.accelerometer, accelerometer_residual(fits.accelerometer), DRAWS, rng)
    else:
        values = drawn(fits.gyroscope.joint, gyroscope_residual(fits), DRAWS, rng, DEG_H_PER_DEG_S)
    sigma = sigma_of(fits, triad)
    ratio = values.std(axis=0)[SHOWN] / sigma[SHOWN]
    assert np.max(np.abs(ratio - 1)) < 3.5 * OWN
    assert abs(np.mean(ratio) - 1) < 2 * OWN


def sigma_of(fits: CampaignFits, triad: str) -> FloatArray:
    """1 sigma (15,) by the fit alone: what `triad_vector` adds for what a fit does not see is not drawn here."""
    joint = fits.accelerometer if triad == "accelerometer" or fits.gyroscope is None else fits.gyroscope.joint
    assert joint is not None
    vector = triad_vector(joint, triad, fits.accelerometer)
    sigma: FloatArray = np.sqrt(np.diag(vector.jacobian @ joint.fit.covariance @ vector.jacobian.T))
    return sigma


@pytest.mark.proof
def test_the_budget_is_the_scatter_of_whole_campaigns_redrawn() -> None:
    """A few of the thousands that the proof `budget` draws: a wrong share of a half is seen."""
    found = compare([trial(seed, "short noisy dwells") for seed in range(24)])
    assert np.max(np.abs(np.log(found.std))) < 4.5 * found.own_std
    assert abs(np.mean(np.log(found.std[:12]))) < 3 * found.own_std / np.sqrt(3)
    assert 0.92 < found.covered.mean() < 0.98  # 576 intervals, those of a campaign not independent
